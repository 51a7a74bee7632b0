#!/usr/bin/env python3
"""Counts deviations from MISRA C:2012 in the firmware's core, its app and shared code by Cppcheck, and compares them
with the justified ones in tools/safety/misra.tsv. docs/safety_code.md explains the counts.

  misra.py             count (a minute of processor time), print a table, write out/misra.tsv
  misra.py --write     write the present counts into tools/safety/misra.tsv; a new rule still needs a justification

Exit code 1: a count has risen, or a rule is new. 2: Cppcheck is missing or did not run. A count is the number of lines
with a deviation. Rules are named by their numbers alone, because their texts are copyrighted.
"""

import argparse
import os
import re
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
TABLE = "tools/safety/misra.tsv"
FIGURES = "out/misra.tsv"
PARTS = ("firmware/core", "firmware/app", "shared")
# The C code that every board runs, or has as a twin of its assembly; not the lanes, which are for x86-64 alone.
OPTIONS = ["--addon=misra", "--std=c11", "--platform=unix32", "-I.", "-U__x86_64__", "-D__thumb__=0", "--quiet"]
FINDING = re.compile(r"^(?P<file>[^:]+):(?P<line>\d+):misra-c2012-(?P<rule>[0-9.]+):", re.M)


class CannotCount(Exception):
    """Why the deviations could not be counted, with the remedy."""


def sources():
    listed = subprocess.run(["git", "ls-files", "*.c"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [path for path in listed.split() if path.startswith(PARTS) and "/tests/" not in path]


def findings(paths, folder=ROOT, jobs=1):
    """Returns {(rule, file, line)} of the C files."""
    command = ["cppcheck", *OPTIONS, "--template={file}:{line}:{id}:{message}", "-j", str(jobs), *paths]
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise CannotCount("cppcheck is missing. Remedy: apt-get install cppcheck") from None
    if done.returncode != 0 or "misra.py" in done.stderr:
        raise CannotCount("cppcheck stopped\n" + (done.stdout + done.stderr)[-2000:])
    return {(m["rule"], m["file"], int(m["line"])) for m in FINDING.finditer(done.stdout + done.stderr)}


def by_number(rule):
    return [int(number) for number in rule.split(".")]


def counts_of(found):
    """Returns {rule: [lines in each part]}."""
    counts = {}
    for rule, path, _ in found:
        for index, part in enumerate(PARTS):
            if path.startswith(part + "/"):
                counts.setdefault(rule, [0] * len(PARTS))[index] += 1
    return counts


def table():
    """Returns {rule: ([counts], justification)} of the tracked table."""
    rows = {}
    with open(os.path.join(ROOT, TABLE), encoding="ascii") as file:
        for line in file:
            if not line.startswith("#"):
                rule, *counts, why = line.rstrip("\n").split("\t")
                rows[rule] = ([int(count) for count in counts], why)
    return rows


def faults(counts, rows):
    """Returns one line for each new rule, missing justification and risen count."""
    result = []
    for rule in sorted(counts, key=by_number):
        allowed, why = rows.get(rule, ([0] * len(PARTS), ""))
        if not why:
            result.append("rule %s has no justification in %s" % (rule, TABLE))
        for part, count, most in zip(PARTS, counts[rule], allowed, strict=True):
            if count > most:
                result.append("rule %s: %d lines in %s, at most %d are justified" % (rule, count, part, most))
    return result


def write(counts, rows):
    """Writes the present counts; keeps the justifications."""
    lines = ["# rule\t%s\tjustification (docs/safety_code.md)" % "\t".join(PARTS)]
    for rule in sorted(counts, key=by_number):
        lines.append("\t".join([rule, *map(str, counts[rule]), rows.get(rule, ([], ""))[1]]))
    with open(os.path.join(ROOT, TABLE), "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--write", action="store_true", help="write the present counts into the table")
    parser.add_argument("--jobs", type=int, default=1, help="processes at once (1)")
    given = parser.parse_args()
    try:
        found = findings(sources(), jobs=given.jobs)
    except CannotCount as problem:
        print(problem, file=sys.stderr)
        return 2
    counts = counts_of(found)
    rows = table()
    if given.write:
        write(counts, rows)
        rows = table()
    print("rule   " + "".join("%15s" % part for part in PARTS))
    for rule in sorted(counts, key=by_number):
        print("%-7s" % rule + "".join("%15d" % count for count in counts[rule]))
    total = sum(sum(row) for row in counts.values())
    os.makedirs(os.path.join(ROOT, "out"), exist_ok=True)
    with open(os.path.join(ROOT, FIGURES), "w", encoding="ascii") as file:
        file.write("misra.lines\t%d\t\t\nmisra.rules\t%d\t\t\n" % (total, len(counts)))
    problems = faults(counts, rows)
    for problem in problems:
        print(problem)
    print("%d lines deviate from %d rules%s" % (total, len(counts), "" if problems else ", all justified"))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
