#!/usr/bin/env python3
"""Runs every test program and test script that has a given label, and prints one line of totals. The script
run_tests.sh calls this program.

  run_tests.py --build build --jobs 2 --label product|lab|hours

The list of tests comes from CTest. The list of tests has all tests of the folder BUILD with the label, and those of
BUILD/san, which are the same tests under sanitizers. With the label `product` the list also has the fuzz
targets. Every test program and test script prints its results as TAP, which is a plan `1..N` and one line per test. A
program counts as one failed test if it is missing, crashes, exceeds its time limit, or prints fewer or more results
than it planned. Output lines that begin with `#- ` are measured figures; the runner prints them below the line of their
program. After the list of failures, the runner prints the duration of each program in seconds, slowest first. The last
line is `N passed, N failed, N skipped`; the exit code is 1 when a test failed or no test ran.
"""

import argparse
import concurrent.futures
import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time

import run_fuzz

TIME_LIMIT_S = 600  # of one test; `hours` has ten times as much
OUTPUT_LINES = 60
FUZZ_SECONDS = 3

PLAN = re.compile(r"^1\.\.(\d+)\s*(#.*)?$")
RESULT = re.compile(r"^(not ok|ok)\b(?:\s+(\d+))?\s*(.*)$")
# A test that printed no end of line before its result: "text" + "ok 3 - name".
GLUED = re.compile(r"(not ok|ok) (\d+) (- \S+|# SKIP.*)$")
SKIP = re.compile(r"#\s*skip\S*\s*(.*)$", re.IGNORECASE)


class Outcome:
    """The result of one program."""

    def __init__(self, title):
        self.title = title
        self.passed = 0
        self.failed = []  # names
        self.skipped = []  # name or reason
        self.output = ""
        self.seconds = 0.0
        self.cpu_s = 0.0  # processor time of the program and of all that it started and waited for

    def fail(self, name):
        self.failed.append(name)


def find_result(line, expected):
    """Returns the parts (ok, number, remaining text) of a TAP result line, or None if the line is no result. The line
    `# ok - file`, which CMocka prints at the end, is a comment and not a result."""
    match = RESULT.match(line)
    if match is None:
        glued = GLUED.search(line)
        match = glued if glued and int(glued.group(2)) == expected else None
    if match is None:
        return None
    return match.group(1) == "ok", None if match.group(2) is None else int(match.group(2)), match.group(3).strip()


def read_tap(text, outcome):
    """Counts the results in `text`. A program may print several TAP plans one after another (one per CMocka group), and
    a script may print its TAP plan at the end."""
    planned, seen, plans = 0, 0, 0
    expected = 1
    for line in text.splitlines():
        plan = PLAN.match(line.strip())
        if plan:
            planned += int(plan.group(1))
            plans += 1
            expected = 1 if seen < planned else expected
            continue
        result = find_result(line, expected)
        if result is None:
            continue
        ok, number, rest = result
        name = rest[2:].strip() if rest.startswith("- ") else rest
        seen += 1
        skip = SKIP.search(rest)
        if number is not None and number != expected:
            outcome.fail("%s (numbered %d, expected %d)" % (name, number, expected))
        elif skip:  # CMocka writes `not ok N # SKIP name`
            outcome.skipped.append(rest.replace("# SKIP", "").strip(" -"))
        elif ok:
            outcome.passed += 1
        else:
            outcome.fail(name or "test %d" % expected)
        expected += 1
    if plans == 0:
        outcome.fail("(no plan line 1..N: did it start?)")
    elif seen != planned:
        outcome.fail("(plan says %d tests, %d reported)" % (planned, seen))


def describe_exit(code):
    if code < 0:
        return "killed by %s" % signal.Signals(-code).name
    return "exit code %d" % code


def wait_for(process, time_limit_s):
    """Returns the output of a process that leads its process group, whether it ended within the limit, and the
    processor time in seconds. A process that exceeds the limit is killed with its group."""
    late = threading.Event()

    def kill():
        late.set()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)

    timer = threading.Timer(time_limit_s, kill)
    timer.start()
    with process.stdout:
        output = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    timer.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    return output, not late.is_set(), usage.ru_utime + usage.ru_stime


def run_program(title, command, environment, time_limit_s=TIME_LIMIT_S):
    """Runs one program that prints TAP until the program ends."""
    outcome = Outcome(title)
    start = time.monotonic()
    if not os.access(command[0], os.X_OK):
        outcome.fail("(did not build, or is not executable: %s)" % command[0])
        return outcome
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=environment,
            start_new_session=True,
        )
    except OSError as error:  # such as an interpreter that does not exist
        outcome.fail("(does not start: %s)" % error)
        return outcome
    output, ended, outcome.cpu_s = wait_for(process, time_limit_s)
    outcome.output = output.decode("utf-8", "replace")
    outcome.seconds = time.monotonic() - start
    read_tap(outcome.output, outcome)
    if not ended:
        outcome.fail("(stopped after %d s)" % time_limit_s)
    elif process.returncode != 0 and not outcome.failed:
        outcome.fail("(%s although no test failed)" % describe_exit(process.returncode))
    elif process.returncode < 0:
        outcome.fail("(%s)" % describe_exit(process.returncode))
    return outcome


def run_fuzz_target(name, build):
    """Runs a fuzz target for a short time; this run counts as one test."""
    outcome = Outcome("fuzz " + name)
    start = time.monotonic()
    ok, outcome.output = run_fuzz.run_target(os.path.join(build, "san"), name, FUZZ_SECONDS)
    outcome.seconds = time.monotonic() - start
    if ok:
        outcome.passed = 1
    else:
        outcome.fail("%d s of random inputs" % FUZZ_SECONDS)
    return outcome


def listed(build, label):
    """Returns the name and the labels of each CTest test that has the given label."""
    command = ["ctest", "--test-dir", build, "--show-only=json-v1", "-L", "^%s$" % label]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        return []  # the folder was not configured, which its build has reported
    for test in json.loads(done.stdout)["tests"]:
        for one in test.get("properties", []):
            if one["name"] == "LABELS":
                yield test["name"], one["value"]


def find_tests(options):
    """Stores in `options` the lists of scripts, programs, sanitized programs and fuzz targets that have the label."""
    plain = list(listed(options.build, options.label))
    options.scripts = [name for name, labels in plain if "script" in labels]
    options.programs = [name for name, labels in plain if "script" not in labels]
    under = list(listed(os.path.join(options.build, "san"), options.label))
    options.sanitized = [name for name, labels in under if "fuzz" not in labels]
    options.fuzz = [name[len("fuzz/") :] for name, labels in under if "fuzz" in labels]


def read_times(build):
    """Reads how many seconds each program took in its last run, and returns these numbers as a table; the runner begins
    with the slowest programs."""
    try:
        with open(os.path.join(build, "test_seconds.json"), encoding="utf-8") as file:
            return json.load(file)
    except (OSError, ValueError):
        return {}


def write_times(build, outcomes):
    times = read_times(build)
    times.update({outcome.title: round(outcome.seconds, 1) for outcome in outcomes})
    if not os.path.isdir(build):
        return
    with open(os.path.join(build, "test_seconds.json"), "w", encoding="utf-8") as file:
        json.dump(times, file, indent=0, sort_keys=True)


def print_times(outcomes):
    print("\nseconds of each program, and its processor seconds, slowest first")
    for outcome in sorted(outcomes, key=lambda one: -one.seconds):
        print("%8.1f %8.1f  %s" % (outcome.seconds, outcome.cpu_s, outcome.title))
    print("%8.1f %8.1f  all" % (sum(one.seconds for one in outcomes), sum(one.cpu_s for one in outcomes)))


def make_jobs(options):
    """Returns the tests to run as pairs (function, arguments); scripts come first, because they take longest."""
    environment = dict(os.environ, BUILD=options.build, CMOCKA_MESSAGE_OUTPUT="TAP", PACKAGES="skip")
    for variable in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "CMOCKA_XML_FILE"):
        environment.pop(variable, None)
    sanitized = dict(
        environment,
        BUILD=os.path.join(options.build, "san"),
        ASAN_OPTIONS="detect_stack_use_after_return=1:strict_string_checks=1",
        UBSAN_OPTIONS="print_stacktrace=1",
        CRN_SANITIZED="1",
        CRN_IMAGE=os.path.join(options.build, "firmware", "cournand-mps2_an500.elf"),
    )
    limit_s = TIME_LIMIT_S * (10 if options.label == "hours" else 1)
    jobs = [(run_program, (path, [os.path.join(".", path)], environment, limit_s)) for path in options.scripts]
    for name in options.programs:
        jobs.append((run_program, (name, [os.path.join(options.build, "test", name)], environment)))
    for name in options.sanitized:
        program = os.path.join(options.build, "san", "test", name)
        jobs.append((run_program, (name + " (sanitizers)", [program], sanitized)))
    for name in options.fuzz:
        jobs.append((run_fuzz_target, (name, options.build)))
    return jobs


def slowest_first(jobs, build):
    """Sorts the tests by duration, longest first, because a long test that begins last would run alone at the end."""
    times = read_times(build)
    return sorted(jobs, key=lambda job: -times.get(job[1][0], 0.0))


def print_progress(done, total, outcome):
    counts = "%d passed" % outcome.passed
    if outcome.skipped:
        counts += ", %d skipped" % len(outcome.skipped)
    if outcome.failed:
        counts += ", %d FAILED" % len(outcome.failed)
    print("[%*d/%d] %-58s %s, %.1f s" % (len(str(total)), done, total, outcome.title, counts, outcome.seconds))
    for line in outcome.output.splitlines():
        if line.startswith("#- "):  # a figure that a person wants to see
            print(" " * 8 + line[3:])
    sys.stdout.flush()


def print_failures(outcomes):
    for outcome in outcomes:
        if not outcome.failed:
            continue
        print("\nFAILED %s" % outcome.title)
        for name in outcome.failed:
            print("  not ok: %s" % name)
        lines = [line for line in outcome.output.splitlines() if not re.match(r"ok \d+ - [^#]*$", line)]
        if len(lines) > OUTPUT_LINES:
            print("  ... %d lines before" % (len(lines) - OUTPUT_LINES))
        for line in lines[-OUTPUT_LINES:]:
            print("  | " + line)


def print_skips(outcomes):
    for outcome in outcomes:
        for reason in outcome.skipped:
            print("skipped %s: %s" % (outcome.title, reason))


def run_all(jobs, workers):
    outcomes = []
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        futures = [pool.submit(function, *arguments) for function, arguments in jobs]
        for future in concurrent.futures.as_completed(futures):
            outcomes.append(future.result())
            print_progress(len(outcomes), len(jobs), outcomes[-1])
    return sorted(outcomes, key=lambda outcome: outcome.title)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="build folder (default: build)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="programs at a time (default: cores)")
    for group in ("programs", "scripts", "sanitized", "fuzz"):
        parser.add_argument("--" + group, nargs="*", default=[], help="these, in place of what CTest has")
    parser.add_argument("--label", choices=("product", "lab", "hours"), default="product")
    options = parser.parse_args()
    start = time.monotonic()
    if not (options.programs or options.scripts or options.sanitized or options.fuzz):
        find_tests(options)
    outcomes = run_all(slowest_first(make_jobs(options), options.build), max(1, options.jobs))
    write_times(options.build, outcomes)
    print_times(outcomes)
    print_skips(outcomes)
    print_failures(outcomes)
    passed = sum(outcome.passed for outcome in outcomes)
    failed = sum(len(outcome.failed) for outcome in outcomes)
    skipped = sum(len(outcome.skipped) for outcome in outcomes)
    print("\ntests ran for %.0f s" % (time.monotonic() - start))
    print("%d passed, %d failed, %d skipped" % (passed, failed, skipped))
    return 1 if failed or passed == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
