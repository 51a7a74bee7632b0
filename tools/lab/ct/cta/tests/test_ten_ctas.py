#!/usr/bin/env python3
"""Ten generated persons: virtual CT angiograms become scenes with at most five clicks, into the longest arteries that
were missed. Prints a row per person, as in docs/own_ct.md, and TAP.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import virtual_cta  # noqa: E402

SEEDS = range(1, 11)
OPTIONS = ("--pixel-mm", "0.9", "--slice-mm", "1.25")
CLICKS_MAX = virtual_cta.CLICKS_MAX
MADE, WIDE_FOUND, FOUND, UNAIDED = 9, 0.95, 0.95, 0.85
APART_MM, RADIUS, FORCE = 0.3, 0.08, 0.10
WORST = 1.1  # times a goal: no single person is farther off, where the goal is for the mean


def main():
    report, rows, findings = virtual_cta.tree.Report(), [], []
    for seed in SEEDS:
        try:
            rows.append(
                virtual_cta.row_of(seed, os.path.join(virtual_cta.BUILD, "virtual_cta", str(seed)), OPTIONS, CLICKS_MAX)
            )
            print("# " + virtual_cta.text_of(rows[-1]), flush=True)
        except RuntimeError as error:
            findings.append(str(error))
    for finding in findings:
        print("# " + finding.replace("\n", " "))
    report.check("at least %d persons become scenes" % MADE, findings if len(rows) < MADE else [])

    def mean(figure):
        return sum(map(figure, rows)) / max(1, len(rows))

    for name, key, least in (
        ("of 4 mm are found", "wide", WIDE_FOUND),
        ("of 2 mm are found with at most %d clicks" % CLICKS_MAX, "all", FOUND),
        ("of 2 mm are found without a click", "unaided", UNAIDED),
    ):
        found = mean(lambda row, key=key: row[key][0])
        report.check("vessels %s" % name, ["only %.0f %%" % (100 * found)] if found < least else [])
    for name, index, goal in (("centrelines", 1, APART_MM), ("radii", 2, RADIUS)):
        average = mean(lambda row, i=index: row["all"][i])
        off = ["on average %.4f" % average] if average > goal else []
        off += ["seed %d: %.4f" % (row["seed"], row["all"][index]) for row in rows if row["all"][index] > WORST * goal]
        report.check("%s are those of the truth within %g on average" % (name, goal), off)
    off = [
        "seed %d: %+.1f %%, %+.1f %%" % ((row["seed"],) + tuple(100 * f for f in row["force"][:2]))
        for row in rows
        if max(abs(f) for f in row["force"][:2]) > FORCE
    ]
    report.check("impulse and usual force on the wall are those of the true lumen", off)
    report.end()


if __name__ == "__main__":
    main()
