#!/usr/bin/env python3
"""These tests check the following. The program tools/lab/peers/run_ct_peers.py compares pictures and times, and
reports errors. In the test, small programs replace our program and DiffDRR, and the address of the package index cannot
be reached. Prints TAP."""

import os
import struct
import subprocess
import tempfile

import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "check"))
import tree  # noqa: E402

RUN = os.path.join(tree.ROOT, "tools", "lab", "peers", "run_ct_peers.py")
PIXELS = 64 * 64
LINE = "code=%s version=9 views=1 ms_min=%g ms_median=%g processor_ms_median=%g"


def write_program(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("#!/bin/bash\n" + text + "\n")
    os.chmod(path, 0o755)


def write_picture(path, values):
    with open(path, "wb") as file:
        file.write(struct.pack("<%df" % len(values), *values))


def run(theirs, ours_ms=10.0, theirs_ms=200.0, ours_values=None, environment=None):
    """Returns the exit code and the output of a run in which replacement programs write the given pictures into the
    folder."""
    with tempfile.TemporaryDirectory() as folder:
        write_picture(folder + "/a", ours_values or [0.5] * PIXELS)
        write_picture(folder + "/b", theirs)
        write_program(
            folder + "/ours", "cp %s/a $1/ours_0.f32; echo '%s'" % (folder, LINE % ("cournand", 9, 10, ours_ms))
        )
        write_program(
            folder + "/peers/bin/python",
            "case $1 in -c) ;; *) cp %s/b $2/diffdrr_0.f32; echo noise; echo '%s';; esac"
            % (folder, LINE % ("diffdrr", 90, 100, theirs_ms)),
        )
        done = subprocess.run(
            [
                RUN,
                "--ours",
                folder + "/ours",
                "--edge",
                "32",
                "--size",
                "64",
                "--environment",
                environment or folder + "/peers",
                "--output",
                folder + "/table.tsv",
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
            env=dict(os.environ, PIP_NO_INDEX="1"),
        )
    return done.returncode, done.stdout


def expect(report, name, got, code, *texts):
    findings = ["exit code %d, expected %d" % (got[0], code)] if got[0] != code else []
    findings += ["no '%s' in:\n%s" % (text, got[1]) for text in texts if text not in got[1]]
    report.check(name, findings)


def main():
    report = tree.Report()
    expect(
        report,
        "difference and ratios are printed",
        run([0.502] * PIXELS),
        0,
        "0.400 % over 4096 pixels",
        "20.0 by processor time (bar 10), 10.0 by medians of the clock",
    )
    expect(report, "a difference above the bar fails", run([0.51] * PIXELS), 1, "view 0 differs by 2.00 %")
    expect(
        report, "a ratio below the bar fails", run([0.5] * PIXELS, theirs_ms=90.0), 1, "9.0 times faster, the bar is 10"
    )
    expect(report, "a picture of another size is named", run([0.5] * 7), 1, "7 pixels, expected 4096")
    with tempfile.TemporaryDirectory() as folder:
        expect(
            report,
            "without a network it says what is missing and that nothing else needs it",
            run([0.5] * PIXELS, environment=folder + "/none"),
            1,
            "it takes a network",
            "Nothing else of the project needs it",
        )
    report.end()


if __name__ == "__main__":
    main()
