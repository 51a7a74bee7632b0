#!/usr/bin/env python3
"""These tests check the following. Every program prints its version, and the changelog begins with the present
version. Prints TAP."""

import os
import re
import subprocess

import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

BUILD = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"), "bin")
NAMES = (
    "cournand",
    "anatomy",
    "bake",
    "centreline",
    "docs",
    "hil",
    "hil_rig",
    "hil_campaign",
    "hil_lies",
    "soak",
)


def version():
    return re.search(r'CRN_VERSION "(\d+\.\d+\.\d+)"', tree.read("shared/version.h")).group(1)


def answer(name):
    """Returns a program's output, or a sentence if the program prints nothing."""
    try:
        done = subprocess.run(
            [os.path.join(BUILD, name), "--version"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=60,
            check=False,
        )
    except OSError as error:
        return str(error)
    return done.stdout.strip() if done.returncode == 0 else "exit code %d: %s" % (done.returncode, done.stdout.strip())


def check_names(report, names):
    for name in names:
        said = answer(name)
        report.check(
            "%s says its version and ends with 0" % name,
            [] if said.startswith("%s %s (Cournand)" % (name, version())) else [said],
        )


def main():
    report = tree.Report()
    check_names(report, NAMES)
    core = re.search(r"CRN_CORE_VERSION = (\d+)", tree.read("firmware/core/core.h")).group(1)
    report.check(
        "cournand says which recordings it replays, and which rigs it talks to",
        [] if re.search(r", core %s, protocol \d+\.\d+$" % core, answer("cournand")) else [answer("cournand")],
    )
    first = re.search(r"^## (\S+)", tree.read("docs/CHANGELOG.md"), re.M).group(1)
    report.check("the changelog begins with this version", [] if first == version() else ["it begins with %s" % first])
    report.end()


if __name__ == "__main__":
    main()
