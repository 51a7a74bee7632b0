#!/usr/bin/env python3
"""Measures the present value of every bar (a limit that the project must keep) and compares it with the bar
(docs/bars.md).

  bars.py --build build [--only TEXT] [--scene FILE] [--tap]

Reads tools/bars/bars.tsv. This program measures values that do not depend on the speed of the machine (instructions,
sizes, hashes, physics); such a value beyond its bar is a failure. If another command measures a value, this program
reads that command's output file. Without this file the program prints "not measured here". If the value is a time, the
program only prints its ratio to the bar; a time never counts as a failure. Writes out/bars.tsv. The program's last
lines, `bars.held<TAB>N` and `bars.red<TAB>N`, give the number of bars that are kept and of bars that fail ("red"). The
exit code is 1 if a value (other than a time) is beyond its bar, that is, its limit, or if this program could not
measure a value. With --tap the program prints one TAP line per bar instead of the table, without times and without
values that other commands measure.
"""

import argparse
import collections
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools", "bench"))
import budget  # noqa: E402
import run_bench  # noqa: E402

LIST = os.path.join("tools", "bars", "bars.tsv")
TABLE = os.path.join("out", "bars.tsv")
SCENE = os.path.join("out", "aorta.scene")
SESSION_TICKS = 20000

Bar = collections.namedtuple("Bar", "name op limit asked issue since source kind")


class CannotMeasure(Exception):
    """Raised when a value cannot be measured; the text gives the reason."""


def read_bars(path=LIST):
    bars = []
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if line.startswith("#") or not line.strip():
                continue
            fields = line.rstrip("\n").split("\t")
            if len(fields) != 8 or fields[1] not in ("<=", ">="):
                raise CannotMeasure("%s:%d: eight columns are wanted, the second <= or >=" % (path, number))
            bars.append(Bar(fields[0], fields[1], float(fields[2]), *fields[3:]))
    return bars


def run(command, limit_s=600):
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=limit_s, check=False)
    except (OSError, subprocess.TimeoutExpired) as problem:
        raise CannotMeasure("%s: %s" % (command[0], problem)) from problem
    if done.returncode != 0:
        raise CannotMeasure(
            "%s: exit code %d: %s" % (" ".join(command), done.returncode, (done.stderr or done.stdout).strip()[-300:])
        )
    return done.stdout


# --- sources: each gives values by name -----------------------------------------------------------------------------
def from_budget(options, _):
    try:
        with tempfile.TemporaryDirectory() as folder:
            rows = budget.measure(options.build, folder)
    except budget.CannotMeasure as problem:
        raise CannotMeasure(str(problem)) from problem
    return {"%s %s" % (name, budget.key_of(context)): value for name, value, _, context in rows}


def from_bench(options, wanted):
    """Returns the values of one benchmark program, but only for those benchmark cases that have a bar (limit)."""
    program = os.path.join(options.build, "bench", "bench_lumen" if wanted[0].startswith("lumen") else "bench_rod")
    values = {}
    try:
        for number, (name, _, context, mode) in enumerate(run_bench.list_cases(program)):
            full = "%s %s" % (name, context)
            named = next((want for want in wanted if full == want or full.startswith(want + " ")), None)
            if named is not None:
                values[named] = run_bench.measure(program, number, mode)
    except run_bench.CannotMeasure as problem:
        raise CannotMeasure(str(problem)) from problem
    return values


LARGEST_ERRORS = {"nested_capstan": "tools.capstan_error_pct", "weight_in_blood": "rod.sag_error_pct"}


def validation_values(text):
    """Returns how many values of the validation suite exceed their tolerance, and for each case the largest ratio of an
    error to its tolerance. Two cases have their largest error under a name of its own."""
    values = collections.defaultdict(float)
    beyond = 0
    for line in text.splitlines()[1:]:
        fields = line.split("\t")
        beyond += fields[9] not in ("pass", "reported")  # tools/lab/validate/report.cpp; any other word counts
        if "-" in (fields[6], fields[7]):
            continue  # a figure that is reported but not judged
        error, tolerance = abs(float(fields[6])), float(fields[7])
        share = error / tolerance if tolerance > 0 else float(error > 0)
        case = fields[0].split(".")[0]
        name = "validation.%s.worst_of_tolerance" % case
        values[name] = max(values[name], share)
        if case in LARGEST_ERRORS:
            values[LARGEST_ERRORS[case]] = max(values[LARGEST_ERRORS[case]], error)
    values["validation.figures_beyond_their_tolerance"] = beyond
    return values


def from_validate(options, _):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [os.path.join(options.build, "bin", "validate"), "--quick", "--jobs", str(options.jobs), "-o", folder],
            cwd=ROOT,
            capture_output=True,
            timeout=600,
            check=False,
        )
        path = os.path.join(folder, "validation.tsv")
        if not os.path.exists(path):
            raise CannotMeasure("build/bin/validate wrote no validation.tsv")
        with open(path, encoding="utf-8") as file:
            return validation_values(file.read())


def from_golden(options, _):
    with tempfile.TemporaryDirectory() as folder:
        program = os.path.join(folder, "hash")
        sources = [
            os.path.join(ROOT, "tools/check", name) for name in ("core_hash.c", "core_scenes.c", "console_stdio.c")
        ]
        run(
            ["gcc", "-std=c11", "-O2", "-I" + ROOT]
            + sources
            + [os.path.join(options.build, "lib", "libfirmware_core.a"), "-o", program]
        )
        now = run([program]).splitlines()
    with open(os.path.join(ROOT, "tools/check/core_hash.golden"), encoding="utf-8") as file:
        golden = file.read().splitlines()
    differ = sum(a != b for a, b in zip(now, golden)) + abs(len(now) - len(golden))
    return {"core.golden_hash_lines_that_differ": differ}


def counted_values(counts):
    """Returns three values of the ticks' costs, as the table of `hil` shows them: the median, the 99.9th percentile and
    the largest value."""
    counts = sorted(counts)
    last = len(counts) - 1
    return {
        "hil.m7_instructions_per_tick " + name: counts[int(share * last + 0.5)]
        for name, share in (("median", 0.5), ("p99.9", 0.999), ("max", 1.0))
    }


def aorta_ticks(options, what):
    """Runs `hil` with the option --counts or --overruns on the aorta session, and returns the second column of the
    written table, which has one value per tick."""
    if not os.path.exists(os.path.join(ROOT, options.scene)):
        raise CannotMeasure("%s does not exist: `make %s` makes it" % (options.scene, SCENE))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "ticks.tsv")
        run([os.path.join(options.build, "bin", "hil"), "--scene", options.scene, what, path], limit_s=1200)
        with open(path, encoding="utf-8") as file:
            return checked_ticks([float(line.split("\t")[1]) for line in file])


def checked_ticks(values):
    """Raises CannotMeasure if the session is too short or if its ticks have no measured cost, because such a session
    would meet every bar (limit)."""
    if len(values) < SESSION_TICKS or min(values) <= 0:
        raise CannotMeasure(
            "the aorta session gave %d ticks (at least %d), the cheapest %g"
            % (len(values), SESSION_TICKS, min(values, default=0))
        )
    return values


def from_counts(options, _):
    return counted_values(aorta_ticks(options, "--counts"))


def overrun_values(edges_us):
    return {
        "hil.edges_over_1_ms at=500_mips": sum(us > 1000 for us in edges_us),
        "hil.edge_us_max at=500_mips": max(edges_us),
    }


def from_overruns(options, _):
    return overrun_values(aorta_ticks(options, "--overruns"))


def from_file(path, wanted):
    """Returns the values by name from a file with the tab-separated columns `name value ...`; in out/bench.tsv the
    fourth column is the context. Returns None without the file."""
    if not os.path.exists(os.path.join(ROOT, path)):
        return None
    values = {}
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        for line in file:
            fields = line.rstrip("\n").split("\t")
            full = fields[0] + (" " + fields[3] if len(fields) > 3 else "")
            for name in wanted:
                if len(fields) > 1 and (full == name or full.startswith(name + " ") or fields[0] == name):
                    values[name] = float(fields[1])
    return values


def measure(source, wanted, options):
    if source.startswith("file:"):
        return from_file(source[len("file:") :], wanted)
    known = {
        "budget": from_budget,
        "bench": from_bench,
        "validate": from_validate,
        "golden": from_golden,
        "counts": from_counts,
        "overruns": from_overruns,
    }
    return known[source.split(":")[0]](options, wanted)


# --- verdicts ----------------------------------------------------------------------------------------------------
def judge(bar, value):
    """Compares a value with its bar (limit) and returns 'held', 'red' (failed), 'time' or 'not measured here'."""
    if bar.kind == "time":
        return "not measured here" if value is None else "time"
    if value is None:
        return "not measured here" if bar.source.startswith("file:") else "red"
    return "held" if (value <= bar.limit if bar.op == "<=" else value >= bar.limit) else "red"


def text_of(value):
    return "-" if value is None else ("%.6g" % value if abs(value) < 1e6 else "%.0f" % value)


def ratio_of(bar, value):
    return "-" if value is None or bar.limit == 0 else "%.2f" % (value / bar.limit)


def values_of(source, bars, options):
    """Returns values by name. If a group of values cannot be measured, the function prints the reason, and the bars
    (limits) of this group count as failed ("red")."""
    try:
        return measure(source, [bar.name for bar in bars if bar.source == source], options) or {}
    except CannotMeasure as problem:
        print("bars: %s: %s" % (source, problem), file=sys.stderr)
        return {}


def text_of_bar(bar, value, width):
    verdict = judge(bar, value)
    note = "  (%s)" % bar.source[len("file:") :] if verdict == "not measured here" else ""
    return "%-*s %s %-10s now %-10s ratio %-5s since %s  %s%s" % (
        width,
        bar.name,
        bar.op,
        text_of(bar.limit),
        text_of(value),
        ratio_of(bar, value),
        bar.since,
        verdict,
        note,
    )


def print_tap(bars, options):
    """Measures one group of values after another and prints one TAP line per bar (limit). Returns the number of failed
    (red) bars."""
    red = number = 0
    print("1..%d" % len(bars), flush=True)
    for source in dict.fromkeys(bar.source for bar in bars):
        values = values_of(source, bars, options)
        for bar in (bar for bar in bars if bar.source == source):
            number += 1
            is_red = judge(bar, values.get(bar.name)) == "red"
            red += is_red
            if is_red:
                print("#", text_of_bar(bar, values.get(bar.name), 0))
            print("%s %d - %s" % ("not ok" if is_red else "ok", number, bar.name), flush=True)
    return red


def report(bars, options):
    """Prints and writes the table. Returns the number of failed (red) bars."""
    values = {source: values_of(source, bars, options) for source in dict.fromkeys(bar.source for bar in bars)}
    verdicts = collections.Counter()
    width = max(len(bar.name) for bar in bars)
    rows = []
    for bar in bars:
        value = values[bar.source].get(bar.name)
        verdict = judge(bar, value)
        verdicts[verdict] += 1
        print(text_of_bar(bar, value, width))
        rows.append(
            (
                bar.name,
                bar.op + text_of(bar.limit),
                text_of(value),
                ratio_of(bar, value),
                bar.asked,
                bar.issue,
                bar.since,
                bar.kind,
                verdict,
            )
        )
    os.makedirs(os.path.join(ROOT, "out"), exist_ok=True)
    with open(os.path.join(ROOT, TABLE), "w", encoding="utf-8") as file:
        file.write("name\tbar\tnow\tratio\tasked\tissue\tsince\tkind\tverdict\n")
        file.writelines("\t".join(row) + "\n" for row in rows)
        file.write("bars.held\t%d\nbars.red\t%d\n" % (verdicts["held"], verdicts["red"]))
    print("bars.not_measured_here\t%d" % verdicts["not measured here"])
    print("bars.held\t%d" % verdicts["held"])
    print("bars.red\t%d" % verdicts["red"])
    return verdicts["red"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="build folder (default: build)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="of validate (default: cores)")
    parser.add_argument("--only", default="", help="only bars with this text in their name or source")
    parser.add_argument("--scene", default=SCENE, help="of the aorta session (default: %s)" % SCENE)
    parser.add_argument(
        "--tap", action="store_true", help="TAP of what is measured here and fails, and no out/bars.tsv"
    )
    options = parser.parse_args()
    try:
        bars = [
            bar
            for bar in read_bars()
            if (options.only in bar.name or options.only in bar.source)
            and not (options.tap and (bar.source.startswith("file:") or bar.kind == "time"))
        ]
    except CannotMeasure as problem:
        print("bars: %s" % problem, file=sys.stderr)
        return 1
    if not bars:
        print("bars: no bar has '%s' in its name" % options.only, file=sys.stderr)
        return 2
    return 1 if (print_tap if options.tap else report)(bars, options) else 0


if __name__ == "__main__":
    sys.exit(main())
