#!/usr/bin/env python3
"""These tests check the following. The test runner (run_tests.py) and the benchmark runner (run_bench.py) report
every error. For each claim, the test runs a small program that misbehaves in one respect. Prints TAP."""

import os
import subprocess
import tempfile

import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

RUN_TESTS = os.path.join(tree.ROOT, "tools", "check", "run_tests.py")
RUN_BENCH = os.path.join(tree.ROOT, "tools", "bench", "run_bench.py")

# name -> (script, expected last line, expected exit code, text that must appear)
PROGRAMS = {
    "a program whose tests pass is counted": (
        "echo 1..2; echo ok 1 - a; echo ok 2 - b",
        "2 passed, 0 failed, 0 skipped",
        0,
        "",
    ),
    "a figure of a passing program is shown": (
        "echo 1..1; echo '#- 3 mm'; echo ok 1 - a",
        "1 passed, 0 failed, 0 skipped",
        0,
        "        3 mm",
    ),
    "a failed test is named and its output shown": (
        "echo 1..2; echo ok 1 - a; echo not ok 2 - tip_is_bent; echo '# 3 mm'; exit 1",
        "1 passed, 1 failed, 0 skipped",
        1,
        "tip_is_bent",
    ),
    "a skip in CMocka's spelling is counted as a skip": (
        "echo 1..2; echo ok 1 - a; echo 'not ok 2 # SKIP b'",
        "1 passed, 0 failed, 1 skipped",
        0,
        "skipped",
    ),
    "a skip in TAP's spelling is counted with its reason": (
        "echo 1..2; echo ok 1 - a; echo 'ok 2 - b # SKIP no anatomy'",
        "1 passed, 0 failed, 1 skipped",
        0,
        "no anatomy",
    ),
    "only skips are not a success": ("echo 1..1; echo 'ok 1 - b # SKIP why'", "0 passed, 0 failed, 1 skipped", 1, ""),
    "a program without a plan fails": ("echo ok 1 - a", "1 passed, 1 failed, 0 skipped", 1, "no plan line"),
    "a program that prints nothing fails": ("exit 0", "0 passed, 1 failed, 0 skipped", 1, "no plan line"),
    "a test missing from the plan fails": (
        "echo 1..3; echo ok 1 - a; echo ok 2 - b",
        "2 passed, 1 failed, 0 skipped",
        1,
        "plan says 3 tests, 2 reported",
    ),
    "a crash after the last test fails": (
        "echo 1..1; echo ok 1 - a; kill -SEGV $$",
        "1 passed, 1 failed, 0 skipped",
        1,
        "SIGSEGV",
    ),
    "a non-zero exit without a failed test fails": (
        "echo 1..1; echo ok 1 - a; exit 3",
        "1 passed, 1 failed, 0 skipped",
        1,
        "exit code 3",
    ),
    "a test number out of order fails": (
        "echo 1..2; echo ok 1 - a; echo ok 3 - b",
        "1 passed, 1 failed, 0 skipped",
        1,
        "numbered 3, expected 2",
    ),
    "a plan at the end is accepted": ("echo ok 1 - a; echo 1..1", "1 passed, 0 failed, 0 skipped", 0, ""),
    "two groups with a plan each are both counted": (
        "echo 1..1; echo ok 1 - a; echo 1..2; echo ok 1 - b; echo ok 2 - c",
        "3 passed, 0 failed, 0 skipped",
        0,
        "",
    ),
    "a group whose set-up failed is counted as failed": (
        "echo 1..1; echo 'not ok 0 - g [  FAILED  ] GROUP SETUP'; exit 1",
        "0 passed, 1 failed, 0 skipped",
        1,
        "GROUP SETUP",
    ),
    "a result glued to the text before it is found": (
        "echo 1..1; echo 'half a lineok 1 - a'",
        "1 passed, 0 failed, 0 skipped",
        0,
        "",
    ),
    "comments and messages are no results": (
        "echo 1..1; echo '# ok - file'; echo 'ok 1 - a'; echo '# not ok - file'",
        "1 passed, 0 failed, 0 skipped",
        0,
        "",
    ),
}

LIST = r"printf 'x.us\tus\tk=1\tvalue\n'"
BENCHES = {
    "a measured value is written with unit and context": (
        "case $1 in list) %s;; run) echo note; echo 2.5;; esac" % LIST,
        0,
        "x.us\t2.5\tus\tk=1",
    ),
    "a case that fails is named": (
        "case $1 in list) %s;; run) echo 'no field' >&2; exit 1;; esac" % LIST,
        1,
        "no field",
    ),
    "a value that is no number is refused": ("case $1 in list) %s;; run) echo soon;; esac" % LIST, 1, "no number"),
    "a program without cases is refused": ("exit 0", 1, "no cases"),
    "a list with missing columns is refused": ("echo x us", 1, "columns"),
    "an unknown mode is refused": (r"printf 'x\tus\tk=1\tguess\n'", 1, "neither value nor callgrind"),
}


def script(folder, name, text):
    path = os.path.join(folder, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("#!/bin/bash\n" + text + "\n")
    os.chmod(path, 0o755)
    return path


def run(command, folder):
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    return done.returncode, done.stdout.decode("utf-8", "replace")


def expect(report, name, wanted, got):
    report.check(
        name,
        ["%s: expected %r, got %r" % (what, wanted[what], got[what]) for what in wanted if wanted[what] != got[what]],
    )


def check_program(report, name, text, last_line, code, part):
    with tempfile.TemporaryDirectory() as folder:
        script(folder, "build/test/sample", text)
        got_code, output = run([RUN_TESTS, "--programs", "sample"], folder)
    expect(
        report,
        name,
        {"exit code": code, "last line": last_line, "has " + part: True},
        {"exit code": got_code, "last line": (output.splitlines() or [""])[-1], "has " + part: part in output},
    )


def check_bench(report, name, text, code, part):
    with tempfile.TemporaryDirectory() as folder:
        got_code, output = run([RUN_BENCH, "--only-programs", script(folder, "bench", text)], folder)
        table = os.path.join(folder, "out", "bench.tsv")
        if os.path.exists(table):
            with open(table, encoding="utf-8") as file:
                output += file.read()
    expect(
        report, name, {"exit code": code, "has " + part: True}, {"exit code": got_code, "has " + part: part in output}
    )


def check_no_program(report):
    with tempfile.TemporaryDirectory() as folder:
        code, output = run([RUN_TESTS, "--programs", "gone", "--fuzz", "gone"], folder)
        expect(
            report,
            "programs that did not build are counted as failed",
            {"exit code": 1, "last": "0 passed, 2 failed, 0 skipped"},
            {"exit code": code, "last": output.splitlines()[-1]},
        )
        with open(script(folder, "build/test/sample", ""), "w", encoding="utf-8") as file:
            file.write("#!/ usr / bin / env python3\n")
        code, output = run([RUN_TESTS, "--programs", "sample"], folder)
        expect(
            report,
            "a script whose interpreter does not exist is counted as failed",
            {"exit code": 1, "last": "0 passed, 1 failed, 0 skipped"},
            {"exit code": code, "last": output.splitlines()[-1]},
        )
        code, output = run([RUN_TESTS], folder)
        expect(report, "a run without any test is no success", {"exit code": 1}, {"exit code": code})


def main():
    report = tree.Report()
    for name, sample in PROGRAMS.items():
        check_program(report, name, *sample)
    check_no_program(report)
    for name, sample in BENCHES.items():
        check_bench(report, name, *sample)
    report.end()


if __name__ == "__main__":
    main()
