#!/usr/bin/env python3
"""A virtual CT angiogram of a generated person becomes a scene without a click, and its arteries are compared with the
true ones. The bars are the goals (docs/own_ct.md), at 1.2 to 20 times what was measured. Prints TAP.
"""

import json
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import virtual_cta  # noqa: E402

OPTIONS = ("--pixel-mm", "0.9", "--slice-mm", "1.25", "--artery-HU", "320", "--noise-HU", "15")
FOUND, APART_MM, RADIUS, FORCE = 0.95, 0.3, 0.08, 0.10
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
    for name, key in (("of 4 mm", "wide"), ("of 2 mm", "all")):
        found, apart_mm, radius = row[key]
        report.check("vessels %s are found without a click" % name, above("share", found, FOUND))
        findings = below("distance in mm", apart_mm, APART_MM) + below("error of radius", radius, RADIUS)
        report.check("centrelines and radii of vessels %s are those of the truth" % name, findings)
    for name, error in zip(("impulse", "force that 95 % of the time stays below"), row["force"]):
        report.check("%s on the wall: as in the true lumen" % name, below("error", abs(error), FORCE))
    report.check("the scene takes less than ten minutes of processor time", below("seconds", row["cpu_s"], GOAL_S))
    report.check("the wall of the true scene pushes the guidewire", above("N", row["true_force"][1], 0.02))
    report.end()


if __name__ == "__main__":
    main()
