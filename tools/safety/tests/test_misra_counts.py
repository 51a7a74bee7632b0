#!/usr/bin/env python3
"""Tests that no count of deviations from MISRA C:2012 has risen (tools/safety/misra.py, a minute of processor time).
Prints TAP."""

import os
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import tap  # noqa: E402


def no_count_has_risen():
    done = subprocess.run(
        [sys.executable, "tools/safety/misra.py"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        print("# " + (done.stdout + done.stderr).replace("\n", "\n# "))
    return done.returncode == 0


if __name__ == "__main__":
    tap.run([no_count_has_risen])
