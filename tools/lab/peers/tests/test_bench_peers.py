#!/usr/bin/env python3
"""These tests check the following. The program tools/lab/peers/run_peers.py compares the values that its programs
print, and reports errors. In the test, small programs replace our programs and the other simulators, and the address of
the package index cannot be reached. Prints TAP."""

import os
import subprocess
import tempfile

import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "check"))
import tree  # noqa: E402

RUN_PEERS = os.path.join(tree.ROOT, "tools", "lab", "peers", "run_peers.py")
LINE = (
    "code=%s version=1 scene=%s step_us=1000 us_per_ms_min=%s us_per_ms_median=%s contacts=9 length_error_pct=%s "
    "tip_x_mm=460.96 tip_z_mm=-180.83 elements=256 bend_N_m2=0.00184791 mass_g_per_m=4.8836 friction=0.2 drag_per_s=20"
)


def line(code, scene, time_us, length_error_pct="0.01"):
    return LINE % (code, scene, time_us, float(time_us) + 1, length_error_pct)


OURS = {"free": line("cournand", "free", 40), "tube": line("cournand", "tube", 50)}
PEERS = {
    ("peer_mujoco.py", "free"): line("mujoco", "free", 900),
    ("peer_mujoco.py", "tube"): line("mujoco", "tube", 1000),
    ("peer_elastica.py", "free"): line("pyelastica", "free", 90000),
}


def write_program(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("#!/bin/bash\n" + text + "\n")
    os.chmod(path, 0o755)


def run(ours, peers, environment=None):
    """Runs run_peers.py with replacement programs that print the given lines; returns the exit code, the output and the
    table."""
    with tempfile.TemporaryDirectory() as folder:
        write_program(
            folder + "/ours", "case $1 in %s esac" % "".join("%s) echo '%s';;" % item for item in ours.items())
        )
        write_program(
            folder + "/peers/bin/python",
            "case $1:$2 in -c:*) ;; %s esac"
            % "".join("*%s:%s) echo '%s';;" % (name, scene, text) for (name, scene), text in peers.items()),
        )
        done = subprocess.run(
            [
                RUN_PEERS,
                "--ours",
                folder + "/ours",
                "--environment",
                environment or folder + "/peers",
                "--repeats",
                "2",
                "--output",
                folder + "/table.tsv",
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
            env=dict(os.environ, PIP_NO_INDEX="1"),
        )
        table = tree.read(folder + "/table.tsv") if os.path.exists(folder + "/table.tsv") else ""
    return done.returncode, done.stdout, table


def expect(report, name, got, code, *texts):
    returned, output, table = got
    findings = ["exit code %d, expected %d" % (returned, code)] if returned != code else []
    findings += ["no '%s' in:\n%s" % (text, output) for text in texts if text not in output + table]
    report.check(name, findings)


def main():
    report = tree.Report()
    expect(
        report,
        "the ratio of every peer is printed and the figures are written",
        run(OURS, PEERS),
        0,
        "mujoco / cournand, tube: 19.6 by medians, 20.0 by minima (bar 10)",
        "pyelastica / cournand, free: 2195.1 by medians, 2250.0 by minima (bar 1000)",
        "mujoco\t1\ttube\t1000\t1000\t1001",
    )
    expect(
        report,
        "a ratio below its bar fails",
        run(dict(OURS, tube=line("cournand", "tube", 150)), PEERS),
        1,
        "below the bar of 10",
    )
    expect(
        report,
        "a peer that is more accurate than ours fails",
        run(dict(OURS, tube=line("cournand", "tube", 50, "-0.5")), PEERS),
        1,
        "not at equal accuracy",
    )
    expect(
        report,
        "codes that simulate different rods fail",
        run(dict(OURS, free=OURS["free"].replace("elements=256", "elements=128")), PEERS),
        1,
        "elements is not the same for all codes: 128, 256",
    )
    expect(
        report,
        "a line without a figure is named",
        run(dict(OURS, free=OURS["free"].replace("contacts=9", "")), PEERS),
        1,
        "has no contacts",
    )
    expect(
        report,
        "a figure that is no number is named",
        run(dict(OURS, free=OURS["free"].replace("contacts=9", "contacts=many")), PEERS),
        1,
        "contacts=many is no number",
    )
    expect(report, "a program that prints nothing is named", run({}, PEERS), 1, "has no code")
    with tempfile.TemporaryDirectory() as folder:
        expect(
            report,
            "without a network it says what is missing and that nothing else needs it",
            run(OURS, PEERS, folder + "/none"),
            1,
            "it takes a network",
            "Nothing else of the project needs them",
        )
    report.end()


if __name__ == "__main__":
    main()
