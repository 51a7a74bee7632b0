#!/usr/bin/env python3
"""Analyses the code with fixed-point numbers, the lumen and the app's safety code with Frama-C EVA, and compares the
alarms with the explained ones in tools/safety/eva_alarms.toml. docs/safety_code.md says what the analysis shows.

  eva.py                  analyse all drivers (a minute), print a table, write out/eva.tsv
  eva.py --only fixed     one driver
  eva.py --write          write the present line numbers of the explained alarms, too

Exit code 1: an alarm is new, an explained one has vanished, or a fact that a driver asserts is not proved.
2: Frama-C is missing or could not analyse a driver.
"""

import argparse
import csv
import os
import re
import subprocess
import sys
import tempfile
import tomllib

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
ALARMS = "tools/safety/eva_alarms.toml"
FIGURES = "out/eva.tsv"
STATEMENTS_LEAST_PERCENT = 95  # a driver that does not reach the code proves nothing about it

# The words and pointers of the board: 32 bits, least significant byte first.
MACHINE = ["-machdep", "gcc_x86_32"]
# Lanes are code for x86-64 alone (firmware/core/lanes.h), which no board runs.
PREPROCESSOR = "-I. -U__x86_64__ -include tools/safety/eva/builtins.h"
ZEROS = "eva_leading_zeros_32:full,eva_leading_zeros_64:full,crn_clz64:full"
FOUND = "coarse_brick_at:0,place_in_brick:0,find_in_scene:0,find_in_near:0,find:0"
SPLIT = "eva_leading_zeros_64:100,crn_clz64:200,crn_sqrt64:200,crn_vec3_normalise:200,every_asin:1000,every_angle:100"
DRIVERS = {
    "fixed": (
        ["firmware/core/fixed.c", "firmware/core/fixed_tables.c"],
        ["-eva-precision", "3", "-eva-split-return-function", ZEROS, "-eva-interprocedural-splits"]
        + ["-eva-slevel-function", SPLIT],
    ),
    "lumen": (
        ["firmware/core/lumen.c", "firmware/core/near/near.c", "firmware/core/fixed_tables.c"],
        ["-eva-precision", "3", "-eva-split-return-function", ZEROS + "," + FOUND, "-eva-interprocedural-splits"]
        + ["-eva-slevel-function", "inward:300,every_scene:50,eva_main:50"],
    ),
    "safety": (
        ["firmware/app/safety/%s.c" % name for name in ("carriage", "cycle", "drive", "safety")],
        ["-eva-precision", "1"],
    ),
    "timing": (
        ["firmware/app/safety/%s.c" % name for name in ("clock", "permission", "watchdog")],
        ["-eva-precision", "3"],
    ),
}
ALARM = re.compile(r"(?P<file>\S+):(?P<line>\d+) (?P<function>\w+) (?P<kind>\w+) \| (?P<property>.+)$")


class CannotAnalyse(Exception):
    """Why a driver could not be analysed, with the remedy."""


def plain(text):
    """Returns a property in ASCII, and without the numbers that Frama-C adds to names."""
    for sign, word in (("\u2264", "<="), ("\u2265", ">="), ("\u2261", "=="), ("\u2227", "&&"), ("\u2228", "||")):
        text = text.replace(sign, word)
    return re.sub(r"\b(crn_\w+?|safety)_\d+\b", r"\1", text)


def key_of(alarm):
    """What identifies an alarm; its line may move."""
    return (alarm["driver"], alarm["file"], alarm["function"], alarm["kind"], alarm["property"])


def analyse(driver, folder):
    """Returns (properties, percent of statements reached, alarms that Frama-C counts) of one driver."""
    sources, options = DRIVERS[driver]
    table = os.path.join(folder, driver + ".csv")
    command = ["frama-c", *MACHINE, "-cpp-extra-args=" + PREPROCESSOR, "-main", "eva_main", "-eva", *options]
    command += ["-eva-no-show-progress", "tools/safety/eva/%s.c" % driver, *sources]
    command += ["-then", "-report-csv", table]
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise CannotAnalyse("frama-c is missing. Remedy: apt-get install frama-c-base") from None
    reached = re.search(r"statements reached \(out of \d+\): (\d+)% coverage", done.stdout)
    if done.returncode != 0 or reached is None or not os.path.exists(table):
        raise CannotAnalyse("%s: Frama-C stopped\n%s" % (driver, (done.stdout + done.stderr)[-2000:]))
    with open(table, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)), int(reached.group(1))


def alarms_of(driver, properties):
    """Returns the alarms and the asserted facts that are not proved, without duplicates."""
    found = {}
    for row in properties:
        ours = row["directory"].startswith(("firmware", "shared", "tools"))
        if not ours or row["status"] in ("Considered valid", "Valid", "Dead"):
            continue
        alarm = {
            "driver": driver,
            "file": row["directory"] + "/" + row["file"],
            "line": int(row["line"]),
            "function": plain(row["function"]),
            "kind": row["property kind"].replace(" ", "_"),
            "property": plain(row["property"]),
        }
        found.setdefault(key_of(alarm), alarm)
    return found


def facts_of(properties):
    return sum(row["property kind"] == "user assertion" and row["status"] == "Valid" for row in properties)


def explained():
    """Returns the alarms of the tracked list by their keys."""
    with open(os.path.join(ROOT, ALARMS), "rb") as file:
        reasons = tomllib.load(file)["reason"]
    known = {}
    for reason in reasons:
        for text in reason["alarms"]:
            match = ALARM.match(text)
            if match is None:
                raise CannotAnalyse("%s: '%s' is no alarm" % (ALARMS, text))
            alarm = dict(match.groupdict(), driver=reason["driver"])
            known[key_of(alarm)] = dict(alarm, line=int(alarm["line"]))
    return known


def text_of(alarm):
    return "%(file)s:%(line)d %(function)s %(kind)s | %(property)s" % alarm


def differences(found, known, drivers):
    """Returns one line per difference between the found and the explained alarms."""
    new = ["new alarm (%s): %s" % (key[0], text_of(found[key])) for key in found if key not in known]
    gone = [
        "vanished alarm (%s): %s" % (key[0], text_of(known[key]))
        for key in known
        if key[0] in drivers and key not in found
    ]
    return new + gone


def write_lines(found, known):
    """Writes the present line numbers into the tracked list."""
    path = os.path.join(ROOT, ALARMS)
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for key, alarm in known.items():
        if key in found:
            text = text.replace(text_of(alarm), text_of(found[key]))
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def run(drivers):
    """Analyses the drivers; returns (alarms, lines of figures, faults)."""
    found, figures, faults = {}, [], []
    with tempfile.TemporaryDirectory() as folder:
        for driver in drivers:
            properties, reached = analyse(driver, folder)
            alarms = alarms_of(driver, properties)
            found.update(alarms)
            facts = facts_of(properties)
            print(
                "%-8s %3d %% of statements reached, %2d facts proved, %2d alarms"
                % (driver, reached, facts, len(alarms))
            )
            figures.append("eva.alarms\t%d\t\t%s" % (len(alarms), driver))
            figures.append("eva.statements\t%d\t%%\t%s" % (reached, driver))
            if reached < STATEMENTS_LEAST_PERCENT:
                faults.append("%s: only %d %% of the statements were reached" % (driver, reached))
    return found, figures, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--only", choices=sorted(DRIVERS), help="one driver")
    parser.add_argument("--write", action="store_true", help="write the present line numbers of explained alarms")
    given = parser.parse_args()
    drivers = [given.only] if given.only else list(DRIVERS)
    try:
        known = explained()
        found, figures, faults = run(drivers)
    except CannotAnalyse as problem:
        print(problem, file=sys.stderr)
        return 2
    if given.write:
        write_lines(found, known)
    faults += differences(found, known, drivers)
    for fault in faults:
        print(fault)
    if not given.only:
        os.makedirs(os.path.join(ROOT, "out"), exist_ok=True)
        with open(os.path.join(ROOT, FIGURES), "w", encoding="ascii") as file:
            file.write("\n".join(figures + ["eva.alarms_unexplained\t%d\t\t" % len(faults)]) + "\n")
    print("%d alarms, all explained" % len(found) if not faults else "%d differences from %s" % (len(faults), ALARMS))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
