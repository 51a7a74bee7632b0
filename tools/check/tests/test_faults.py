#!/usr/bin/env python3
"""These tests check the following. Every fault of the device in shared/wire/wire_faults.def names a test, and
this test exists and runs. Prints TAP."""

import re

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

TABLE = "shared/wire/wire_faults.def"
FAULT = re.compile(r'^FAULT\((\w+), (\d+), "(\w+)", (\d+), "(\w+)"', re.M)


def faults_of(text):
    """Returns (name, code, effect, safe_ms, test) of each fault in wire_faults.def."""
    return [(m[0], int(m[1]), m[2], int(m[3]), m[4]) for m in FAULT.findall(text)]


def tests_of(sources):
    """Returns the names of those test functions that the sources define and also list for execution."""
    names = set()
    for text in sources:
        defined = set(re.findall(r"^static void (\w+)\(void \*\*state\)", text, re.M))
        names |= {name for name in re.findall(r"\b(?:TEST|cmocka_unit_test)\((\w+)\),", text, re.M) if name in defined}
    return names


def missing_tests(faults, tests):
    for name, _, _, _, test in faults:
        if test not in tests:
            yield "%s: the test %s of fault %s is not defined and listed in firmware/tests" % (TABLE, test, name)


def slow_faults(faults):
    """Checks that the listed times to the safe state keep their limits: 5 ms after over-force or a sensor fault, and 50
    ms after the host has stopped sending. A broken power stage is an exception, because the device can only report this
    fault."""
    for name, _, effect, safe_ms, _ in faults:
        limit = {"stop": 5, "fade": 50, "log": 0}[effect]
        if safe_ms > limit and name != "STAGE_STUCK":
            yield "%s: %s takes %d ms until it is safe, at most %d" % (TABLE, name, safe_ms, limit)


def self_test(report):
    sample = faults_of('FAULT(A, 1, "stop", 9, "a_test",\n')
    report.catches("a fault without its test is caught", missing_tests(sample, {"another"}))
    report.catches("a fault that takes too long is caught", slow_faults(sample))
    source = "static void a_test(void **state)\n{\n}\n"
    report.catches("a test that is not listed is caught", missing_tests(sample, tests_of([source])))
    report.accepts("a listed test is accepted", missing_tests(sample, tests_of([source + "        TEST(a_test),\n"])))


def main():
    report = tree.Report()
    self_test(report)
    text = tree.read(TABLE)
    faults = faults_of(text)
    tests = tests_of(tree.read(path) for path in tree.files(".c") if path.startswith("firmware/tests/"))
    count = len(re.findall(r"^FAULT\(", text, re.M))
    report.check(
        "all %d faults of the table were read" % count, [] if len(faults) == count else ["%d read" % len(faults)]
    )
    report.check("every fault has its test", missing_tests(faults, tests))
    report.check("every time to safe is within its bar", slow_faults(faults))
    report.end()


if __name__ == "__main__":
    main()
