#!/usr/bin/env python3
"""These tests check the following. The program tools/check/matrix.py --short finds the same hash on five machines (32
and 64 bits, both byte orders). On x86-64 and Cortex-M7, the hash is that of the core's objects that ship. If a machine
computes one bit differently, matrix.py finds the difference and prints the tick, the part of the tick, and the node.
`make matrix` runs all variants. With the argument `breaks`, the test tries only the second and later bits of BREAKS.
Prints TAP."""

import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

MATRIX = os.path.join(tree.ROOT, "tools", "check", "matrix.py")
BREAKS = [("1203", "feed", "0"), ("2", "solve", "7"), ("3001", "friction", "9")]


def matrix(*arguments):
    """Runs matrix.py and returns its exit code, the lines of its table, and its whole output."""
    built = os.environ.get("CRN_SHIPPED") or os.environ.get("BUILD", "build")
    command = [MATRIX, "--built", built] + list(arguments)
    done = subprocess.run(command, cwd=tree.ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    text = done.stdout.decode("utf-8", "replace")
    return done.returncode, text.splitlines(), text


# Requirement: SR-23
def same_hash(folder):
    code, lines, text = matrix("--short", "--programs", folder)
    if code != 0 or "5 of 5 variants agree" not in lines:
        yield "exit code %d: %s" % (code, text)


def break_is_found(folder, tick, part, node):
    bit = ":".join(("x86-32 gcc", tick, part, node))
    code, _, text = matrix("--short", "--programs", folder, "--only", "x86", "--break", bit)
    expected = "scene tube, tick %s, %s, node %s:" % (tick, part, node)
    if code != 1 or expected not in text:
        yield "exit code %d, expected 1 and '%s' in: %s" % (code, expected, text)


def usage_error():
    code, _, text = matrix("--short", "--break", "nowhere:1:solve:1")
    if code != 2:
        yield "exit code %d, expected 2: %s" % (code, text)


def check_breaks(report, folder, breaks):
    for tick, part, node in breaks:
        report.check(
            "one wrong bit at tick %s in '%s' of node %s is found there" % (tick, part, node),
            break_is_found(folder, tick, part, node),
        )


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as folder:
        if sys.argv[1:] == ["breaks"]:
            check_breaks(report, folder, BREAKS[1:])
        else:
            report.check("x86-64, x86-32, Cortex-M7, s390x and riscv64 give one hash", same_hash(folder))
            check_breaks(report, folder, BREAKS[:1])
            report.check("a variant that does not exist is a usage error", usage_error())
    report.end()


if __name__ == "__main__":
    main()
