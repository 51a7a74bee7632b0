#!/usr/bin/env python3
"""Runs the benchmark programs with the command-line arguments that docs/bench.md defines. `make bench` calls this
program.

  run_bench.py --build build [--cases TEXT] [PROGRAM...]

The script writes the results to out/bench.tsv (name, value, unit, context, separated by tabs) and prints them as a
table. With --cases, the script runs only the benchmark cases whose name contains TEXT, and does not change
out/bench.tsv. The exit code is 1 when a benchmark case could not be measured.
"""

import argparse
import glob
import json
import os
import re
import subprocess
import sys
import tempfile
import time

import budget

TABLE = os.path.join("out", "bench.tsv")
TIME_LIMIT_S = 900
SESSION = "session.realtime_factor"
PERSON = "patient.generate_s"
CALIBRATED = "shared/examples/instruments/amplatz_super_stiff.toml"


class CannotMeasure(Exception):
    """Raised when a value cannot be measured; the text gives the reason."""


def run(command):
    """Runs a command, which must succeed, and returns its standard output."""
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            timeout=TIME_LIMIT_S,
            check=False,
        )
    except FileNotFoundError as error:
        raise CannotMeasure("%s is missing: `make bench` builds and installs what it needs" % command[0]) from error
    except subprocess.TimeoutExpired as error:
        raise CannotMeasure("%s: still running after %d s" % (" ".join(command), TIME_LIMIT_S)) from error
    if done.returncode != 0:
        text = (done.stderr or done.stdout).decode("utf-8", "replace").strip().splitlines()
        raise CannotMeasure("%s: exit code %d: %s" % (" ".join(command), done.returncode, "\n".join(text[-8:])))
    return done.stdout.decode("utf-8", "replace")


def list_cases(program):
    """Returns (name, unit, context, mode) of every case of a benchmark program."""
    cases = []
    for line in run([program, "list"]).splitlines():
        fields = line.split("\t")
        if len(fields) != 4:
            raise CannotMeasure("%s list: '%s' has %d columns, expected 4" % (program, line, len(fields)))
        cases.append(fields)
    if not cases:
        raise CannotMeasure("%s list: no cases" % program)
    return cases


def last_number(program, number):
    lines = run([program, "run", str(number)]).split()
    try:
        return float(lines[-1])
    except (IndexError, ValueError) as error:
        raise CannotMeasure("%s run %d: its last line is no number" % (program, number)) from error


def count_calls(profile, function):
    """Counts the calls of `function` in a profile of Callgrind, by adding the `calls=` lines that follow a `cfn=` line
    with its name. Callgrind writes a function's name as `(id) name` the first time and as `(id)` afterwards."""
    ids = {i for i, name in re.findall(r"^c?fn=\((\d+)\) (\S+)", profile, re.M) if name == function}
    return sum(int(calls) for i, calls in re.findall(r"^cfn=\((\d+)\)[^\n]*\ncalls=(\d+)", profile, re.M) if i in ids)


def count_instructions(program, number, function, calls):
    """Returns the mean number of instructions per call of `function`, including the functions that it calls."""
    with tempfile.TemporaryDirectory() as folder:
        profile_path = os.path.join(folder, "callgrind.out")
        run(
            [
                "valgrind",
                "--tool=callgrind",
                "--toggle-collect=" + function,
                "--callgrind-out-file=" + profile_path,
                program,
                "run",
                str(number),
            ]
        )
        with open(profile_path, encoding="utf-8", errors="replace") as file:
            profile = file.read()
    totals = re.search(r"^(?:totals|summary): (\d+)", profile, re.M)
    if totals is None or int(totals.group(1)) == 0:
        raise CannotMeasure("callgrind saw no call of %s in %s: was it inlined?" % (function, program))
    seen = count_calls(profile, function)
    if seen != calls:
        raise CannotMeasure(
            "%s run %d: callgrind saw %d calls of %s, the case states %d" % (program, number, seen, function, calls)
        )
    return int(totals.group(1)) / calls


def measure(program, number, mode):
    if mode == "value":
        return last_number(program, number)
    kind, _, rest = mode.partition(":")
    function, _, calls = rest.partition(":")
    if kind != "callgrind" or not calls.isdigit() or int(calls) == 0:
        raise CannotMeasure("%s: mode '%s' is neither value nor callgrind:FUNCTION:CALLS" % (program, mode))
    return count_instructions(program, number, function, int(calls))


def program_cases(program):
    for number, (name, unit, context, mode) in enumerate(list_cases(program)):
        yield name, unit, context, lambda number=number, mode=mode: measure(program, number, mode)


def demo_command(options):
    """Runs the demo session without writing its pictures and reports."""
    for path in (options.scene, options.instrument, options.session):
        if not os.path.exists(path):
            raise CannotMeasure("%s does not exist: `make run` makes what is missing" % path)
    program = os.path.join(options.build, "bin", "cournand")
    inputs = ["--scene", options.scene, "--instrument", options.instrument, "--session", options.session]
    return [program, "run"] + inputs + ["--quiet"]


def realtime_factor(options, picture_arguments):
    """Returns the simulated seconds per second of real time that the program cournand reports for the demo session."""
    with tempfile.TemporaryDirectory() as folder:
        timing = os.path.join(folder, "timing.json")
        run(
            demo_command(options)
            + ["--timing", timing]
            + [argument.replace("FOLDER", folder) for argument in picture_arguments]
        )
        with open(timing, encoding="utf-8") as file:
            return float(json.load(file)["realtime_factor"])


def session_cases(options):
    pictures = ["--mp4", os.path.join("FOLDER", "film.mp4"), "--size", "512", "--fps", "15"]
    for context, arguments in (("pictures=none", []), ("pictures=512", pictures)):
        yield SESSION, "1", context, lambda arguments=arguments: realtime_factor(options, arguments)


def person_cases(options):
    """The wall time in which `anatomy person` makes all meshes of one person, without the heart's frames."""
    threads = 2

    def seconds():
        with tempfile.TemporaryDirectory() as folder:
            command = [os.path.join(options.build, "bin", "anatomy"), "person", "--seed", "1", "--quiet"]
            start = time.monotonic()
            run(command + ["--threads", str(threads), "-o", folder])
            return time.monotonic() - start

    yield PERSON, "s", "threads=%d" % threads, seconds


def bytes_per_tick(options):
    """Returns the number of bytes per tick in the recording of the demo session."""
    with tempfile.TemporaryDirectory() as folder:
        recording = os.path.join(folder, "demo.rec")
        run(demo_command(options) + ["--record", recording])
        size = os.path.getsize(recording)
        ticks = re.search(r"(\d+) ticks", run([os.path.join(options.build, "bin", "cournand"), "info", recording]))
        if ticks is None:
            raise CannotMeasure("cournand info does not say how many ticks a recording has")
        return size / int(ticks.group(1))


def wire_cases(options):
    yield "wire.bytes_per_tick", "byte", "recording=demo", lambda: bytes_per_tick(options)


def make_calibration(options, folder):
    """Makes the input files of a calibration in the phantom. The second insertion depth of the calibration case is 300
    mm; the virtual scans show the nominal instrument."""
    phantom = os.path.join(folder, "phantom")
    run([os.path.join(options.build, "bin", "anatomy"), "phantom", "-o", phantom, "--no-bodies", "--quiet"])
    text = os.path.join(phantom, "scene.toml")
    run(
        [
            os.path.join(options.build, "bin", "bake"),
            text,
            "-o",
            os.path.join(folder, "phantom.scene"),
            "--points",
            "1000",
            "--poses",
            "0",
        ]
    )
    with open(text, encoding="utf-8") as file:
        entry = dict(re.findall(r"^(position_mm|direction) = (\[.*\])", file.read(), re.M))
    lines = [
        "format = 1",
        'name = "bench"',
        'scene = "phantom.scene"',
        "mouth_mm = " + entry["position_mm"],
        "direction = " + entry["direction"],
        'instrument = "%s"' % os.path.abspath(CALIBRATED),
        "friction_kinetic = 0.1",
        "friction_static = 0.1",
        "speed_mm_per_s = 20",
    ]
    for number, inserted_mm in enumerate((240, 300), 1):
        lines += [
            "[[depth]]",
            'name = "%d mm"' % inserted_mm,
            "inserted_mm = %d" % inserted_mm,
            "turn_deg = 0",
            'centreline = "depth_%d.csv"' % number,
        ]
        with open(os.path.join(folder, "depth_%d.csv" % number), "w", encoding="utf-8") as file:
            file.write("x_mm,y_mm,z_mm\n0,0,0\n1,0,0\n")
    with open(os.path.join(folder, "case.toml"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    run([os.path.join(options.build, "bin", "calibrate"), folder, "--evaluate", "-o", folder])


def calibration_rate(options, threads):
    """Returns the number of simulated insertions per second that the program calibrate reports."""
    with tempfile.TemporaryDirectory() as folder:
        make_calibration(options, folder)
        command = [
            os.path.join(options.build, "bin", "calibrate"),
            folder,
            "-o",
            os.path.join(folder, "fit"),
            "--threads",
            str(threads),
            "--population",
            "16",
            "--generations",
            "4",
            "--no-ranges",
            "--no-page",
        ]
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False
        )
        rate = re.search(r"([0-9.]+) per s$", done.stderr, re.M)
        if done.returncode != 0 or rate is None:
            raise CannotMeasure("%s: %s" % (" ".join(command), done.stderr.strip()[-300:]))
        return float(rate.group(1))


def calibration_cases(options):
    for threads in sorted({1, os.cpu_count() or 1}):
        yield (
            "calibrate.evaluations_per_s",
            "1/s",
            "threads=%d inserted_mm=300" % threads,
            lambda threads=threads: calibration_rate(options, threads),
        )


def budget_rows(options):
    """Returns the rows of values on the Cortex-M7 (tools/bench/budget.py), and the number of rows that could not be
    measured."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            rows = budget.measure(options.build, folder)
        return [(name, text_of(value), unit, context) for name, value, unit, context in rows], 0
    except budget.CannotMeasure as problem:
        print("cannot measure the Cortex-M7's budget: %s" % problem, file=sys.stderr, flush=True)
        return [], 1


def text_of(value):
    return "%.6g" % value if abs(value) < 1000 else "%.0f" % value


def print_table(rows):
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    for name, value, unit, context in rows:
        print("%-*s  %*s  %-*s  %s" % (widths[0], name, widths[1], value, widths[2], unit, context))


# Each of these cases takes minutes, under callgrind or by simulated minutes; --quick leaves them out.
SLOW = ("hands.", "wire.", "rod.coronary_penetration_mm", "xray.", "stent.", "contrast.", "calibrate.", SESSION, PERSON)


def is_slow(name, context):
    return name.startswith(SLOW) or "beating" in context or "balloon" in context or "tools=3" in context


def quick_cases(cases):
    """Returns the benchmark cases that take only seconds, and prints the names of the other cases."""
    left_out = [case for case in cases if is_slow(case[0], case[2])]
    for name, _, context, _ in left_out:
        print("left out: %s %s" % (name, context), file=sys.stderr)
    return [case for case in cases if case not in left_out]


def run_cases(cases, wanted):
    rows, failed = [], 0
    for name, unit, context, function in cases:
        if wanted not in name:
            continue
        try:
            rows.append((name, text_of(function()), unit, context))
            print("measured %s %s: %s" % (name, context, rows[-1][1]), file=sys.stderr, flush=True)
        except CannotMeasure as problem:
            failed += 1
            print("cannot measure %s %s: %s" % (name, context, problem), file=sys.stderr, flush=True)
    return rows, failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="build folder (default: build)")
    parser.add_argument("--cases", default="", help="only cases whose name contains this text (default: all)")
    parser.add_argument(
        "--quick", action="store_true", help="only what takes seconds; says what it leaves out, leaves the file alone"
    )
    parser.add_argument("--scene", default="out/aorta.scene", help="of the session (default: %(default)s)")
    parser.add_argument(
        "--instrument", default="shared/examples/instruments/bentson.toml", help="(default: %(default)s)"
    )
    parser.add_argument("--session", default="shared/examples/sessions/demo.session", help="(default: %(default)s)")
    parser.add_argument(
        "--only-programs", action="store_true", help="leave out what needs the session, and the Cortex-M7's budget"
    )
    parser.add_argument("programs", nargs="*", metavar="PROGRAM", help="(default: every BUILD/bench/bench_*)")
    options = parser.parse_args()
    options.programs = options.programs or sorted(glob.glob(os.path.join(options.build, "bench", "bench_*")))
    cases = []
    try:
        for program in options.programs:
            cases += program_cases(program)
    except CannotMeasure as problem:
        print("run_bench: %s" % problem, file=sys.stderr)
        return 1
    if not options.only_programs:
        cases += wire_cases(options)
        cases += session_cases(options)
        cases += person_cases(options)
        cases += calibration_cases(options)
    cases.sort(key=lambda case: is_slow(case[0], case[2]))
    if options.quick:
        cases = quick_cases(cases)
    rows, failed = run_cases(cases, options.cases)
    if not options.only_programs and (options.cases in "rod.m7_" or options.cases.startswith("rod.m7")):
        more, missed = budget_rows(options)
        rows, failed = rows + [row for row in more if options.cases in row[0]], failed + missed
    if not rows and not failed:
        print("run_bench: no case has '%s' in its name" % options.cases, file=sys.stderr)
        return 2
    if rows:
        print_table(rows)
    if not options.cases and not options.quick:
        os.makedirs("out", exist_ok=True)
        with open(TABLE, "w", encoding="utf-8") as file:
            file.writelines("\t".join(row) + "\n" for row in rows)
        print("written to %s" % TABLE)
    if failed:
        print("%d cases could not be measured" % failed, file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
