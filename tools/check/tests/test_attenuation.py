#!/usr/bin/env python3
"""These tests check the following. The file host/xray/attenuation.cpp is equal, byte for byte, to the file that
make_attenuation.py writes today from xraylib. Prints TAP.

If the library xraylib (Debian's libxrl11, section [test] of tools/packages.txt) is missing, the test is not skipped but
fails and prints the reason.
"""

import difflib
import subprocess
import sys

import os

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

SCRIPT, TABLES = "tools/check/make_attenuation.py", "host/xray/attenuation.cpp"


def differences(stored, made):
    """Returns the differences between the two texts as a diff of at most a few lines."""
    lines = difflib.unified_diff(stored.splitlines(), made.splitlines(), TABLES, SCRIPT, n=0, lineterm="")
    return [line[:120] for line in list(lines)[:8]]


def main():
    report = tree.Report()
    stored = tree.read(TABLES)
    run = subprocess.run([sys.executable, SCRIPT], cwd=tree.ROOT, capture_output=True, text=True, timeout=60)
    faults = differences(stored, run.stdout) if run.returncode == 0 else (run.stderr or "no message").splitlines()[-3:]
    report.check("the attenuation tables are those that their script makes", faults)
    report.check(
        "one changed digit is found",
        [] if differences(stored.replace("1.4247f", "1.4248f", 1), stored) else ["nothing said of a changed value"],
    )
    report.end()


if __name__ == "__main__":
    main()
