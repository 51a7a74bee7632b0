#!/usr/bin/env python3
"""Puts the machine under load, repeats the tests that depend on time, processes or windows, and prints the names of the
tests that fail (docs/bars.md).

  flakes.py --build build [--rounds 30] [--load 4] [--jobs 2] [--tests TEXT]

The tests are listed in tools/bars/flakes.txt, and they run as in `make test`. The program writes out/flakes.tsv after
every round of tests, so that an interrupted run keeps its results. If a test fails, its output is kept in the folder
out/flakes. The last printed line is `flakes.failed<TAB>N`, where N is the number of failed test runs. The exit code is
1 if N is not 0.
"""

import argparse
import collections
import concurrent.futures
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import run_tests  # noqa: E402

LIST = os.path.join(ROOT, "tools", "bars", "flakes.txt")
BUSY = "while True: pass"


def read_list(wanted):
    with open(LIST, encoding="utf-8") as file:
        return [line.strip() for line in file if line.strip() and not line.startswith("#") and wanted in line]


class Load:
    """Keeps the processors busy with `count` processes until the `with` block ends."""

    def __init__(self, count):
        self.busy = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(count)]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.busy:
            process.kill()
            process.wait()


def keep_output(outcome, name, number):
    folder = os.path.join("out", "flakes")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "%s_%d.txt" % (name.replace("/", "_"), number)), "w", encoding="utf-8") as file:
        file.write("\n".join("not ok: " + what for what in outcome.failed) + "\n" + outcome.output)


def run_round(jobs, number, at_once):
    """Runs the tests once and returns the outcomes of the failed tests."""
    pool = concurrent.futures.ThreadPoolExecutor(max(1, at_once))
    try:
        outcomes = [future.result() for future in [pool.submit(function, *arguments) for function, arguments in jobs]]
    finally:
        pool.shutdown(cancel_futures=True)  # an interrupt ends the running tests, and no other test begins
    failed = [outcome for outcome in outcomes if outcome.failed]
    for outcome in failed:
        keep_output(outcome, outcome.title, number)
        print("round %d: FAILED %s: %s" % (number, outcome.title, "; ".join(outcome.failed)), flush=True)
    return failed


def run_rounds(jobs, options):
    """Returns a table that maps each test to the numbers of the rounds in which this test failed."""
    failed = collections.defaultdict(list)
    for number in range(1, options.rounds + 1):
        for outcome in run_round(jobs, number, options.jobs):
            failed[outcome.title].append(number)
        total = write_table(jobs, failed, number, options.load)
        print("round %d of %d: %d failed runs so far" % (number, options.rounds, total), flush=True)
    return failed


def write_table(jobs, failed, rounds, load):
    total = sum(map(len, failed.values()))
    os.makedirs("out", exist_ok=True)
    with open(os.path.join("out", "flakes.tsv"), "w", encoding="utf-8") as file:
        for _, arguments in jobs:
            file.write("%s\t%d\tof %d\n" % (arguments[0], len(failed.get(arguments[0], [])), rounds))
        file.write("flakes.rounds\t%d\nflakes.load\t%d\nflakes.failed\t%d\n" % (rounds, load, total))
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="build folder (default: build)")
    parser.add_argument("--rounds", type=int, default=30, help="(default: 30)")
    parser.add_argument("--load", type=int, default=4, help="busy processes beside them (default: 4)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="tests at a time (default: cores)")
    parser.add_argument("--tests", default="", help="only tests with this text in their name")
    options = parser.parse_args()
    os.chdir(ROOT)
    names = read_list(options.tests)
    if not names:
        print("flakes: no test has '%s' in its name" % options.tests, file=sys.stderr)
        return 2
    scripts = [name for name in names if name.endswith((".sh", ".py"))]
    options.scripts, options.programs = scripts, [name for name in names if name not in scripts]
    options.sanitized, options.fuzz = [], []
    jobs = run_tests.make_jobs(options)
    write_table(jobs, {}, 0, options.load)  # replaces the table of an earlier run
    with Load(options.load):
        failed = run_rounds(jobs, options)
    for title, rounds in sorted(failed.items()):
        print("%-50s failed in %d of %d rounds: %s" % (title, len(rounds), options.rounds, ", ".join(map(str, rounds))))
    total = sum(map(len, failed.values()))
    print("flakes.rounds\t%d" % options.rounds)
    print("flakes.failed\t%d" % total)
    return 1 if total else 0


if __name__ == "__main__":
    sys.exit(main())
