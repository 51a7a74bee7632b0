#!/usr/bin/env python3
"""This test runs the comparison on a moving wire (tools/lab/peers/run_moving.py) with MuJoCo itself, for a few
settings. It checks which settings are right, that our tip and that of a chain with the same stiffness agree, and that
all figures are written. It makes no statement about speed: a ratio below its bar is allowed. It needs a network. Prints
TAP."""

import os
import re
import subprocess
import sys
import tempfile

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.dirname(FOLDER), os.path.join(FOLDER, "..", "..", "..", "check")]
import tree  # noqa: E402

RUN_MOVING = os.path.join(tree.ROOT, "tools", "lab", "peers", "run_moving.py")
BUILD = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"))
# Measured: 0.53 mm, with steps of 6 ms and added armature; three times that.
APART_mm = 1.6


def run(folder, only):
    command = [RUN_MOVING, "--ours", BUILD + "/bench/peer_moving", "--environment", BUILD + "/peers"]
    command += ["--rounds", "1", "--only", only, "--output", folder + "/table.tsv"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.stdout, tree.read(folder + "/table.tsv") if os.path.exists(folder + "/table.tsv") else ""


def value(table, name, context):
    found = re.search(r"^%s\t([^\t]+)\t[^\t]*\t%s$" % (re.escape(name), re.escape(context)), table, re.M)
    return float(found.group(1)) if found else float("nan")


def lines_with(text, *parts):
    return [line for line in text.splitlines() if all(part in line for part in parts)]


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as folder:
        output, table = run(folder, "chain 6 ms, discrete, armature 0.02, 0.001")
        right = lines_with(output, "chain ", "6 ms, discrete", "right")
        report.check("a chain with a step of 6 ms is right", [] if right else [output])
        apart_mm = value(table, "env.moving_apart_mm", "peer=chain counts=1")
        report.check("its tip agrees with ours", [] if apart_mm < APART_mm else ["%g mm apart" % apart_mm])
        ratio = value(table, "env.over_peer", "peer=chain task=moving")
        report.check("its speed is compared with ours", [] if ratio > 0 else [table or output])
        output, table = run(folder, "cathsim 24 ms")
        wrong = lines_with(output, "cathsim ", "24 ms, Euler", "wrong: penetration_mm")
        report.check("CathSim's wire with a step of 24 ms leaves the vessel", [] if wrong else [output])
        is_listed = wrong and re.search(r"dense +[0-9.]+ ", wrong[0])
        report.check("its speed is listed nevertheless", [] if is_listed else [output])
    report.end()


if __name__ == "__main__":
    main()
