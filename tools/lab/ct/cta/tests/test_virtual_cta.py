#!/usr/bin/env python3
"""A virtual CT angiogram of a generated person becomes a scene without a click, and its arteries are compared with the
true ones. The bars stand beyond what ten persons gave (docs/own_ct.md), not at the goals. Prints TAP.
"""

import json
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import virtual_cta  # noqa: E402

OPTIONS = ("--pixel-mm", "0.9", "--slice-mm", "1.25", "--artery-HU", "320", "--noise-HU", "15")
WIDE_FOUND, WIDE_APART_MM, WIDE_RADIUS, ALL_FOUND = 0.85, 0.6, 0.15, 0.55
GOAL_S = 600


def above(what, value, least):
    return ["%s = %.3f, at least %.3f is needed" % (what, value, least)] if value < least else []


def below(what, value, most):
    return ["%s = %.3f, at most %.3f is allowed" % (what, value, most)] if value > most else []


def main():
    report = virtual_cta.tree.Report()
    folder = os.path.join(virtual_cta.BUILD, "virtual_cta", "test")
    row = virtual_cta.row_of(7, folder, OPTIONS)
    print("# " + virtual_cta.text_of(row))
    with open(os.path.join(folder, "found", "report.json"), encoding="utf-8") as file:
        facts = " ".join(json.load(file)["facts"])
    median, noise = map(float, re.search(r"aorta: median (\d+) HU, noise (\d+) HU", facts).groups())
    findings = below("medium, off", abs(median - 320), 4) + below("noise, off", abs(noise - 15), 3)
    report.check("the angiogram has the wanted medium and noise", findings)
    findings = above("share of wide vessels", row["wide"][0], WIDE_FOUND)
    findings += above("share of all vessels of 2 mm", row["all"][0], ALL_FOUND)
    report.check("vessels are found without a click", findings)
    findings = below("distance in mm", row["wide"][1], WIDE_APART_MM) + below("radius", row["wide"][2], WIDE_RADIUS)
    report.check("centrelines and radii of wide vessels are those of the truth", findings)
    report.check("the scene takes less than ten minutes of processor time", below("seconds", row["cpu_s"], GOAL_S))
    report.check("the wall of the true scene pushes the guidewire", above("N", row["true_force"][0], 0.02))
    report.end()


if __name__ == "__main__":
    main()
