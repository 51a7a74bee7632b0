#!/usr/bin/env python3
"""Tests that the shipped arches have the types that their files state. The type follows from the height by which the
brachiocephalic artery leaves the aorta below the top of the arch's outer wall, in widths of the left common carotid
artery: below 1 is type I, 1 to 2 is type II, and above 2 is type III. Prints TAP."""

import json
import math
import os
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "check")]
import tap  # noqa: E402

PROGRAM = os.path.join(ROOT, os.environ.get("BUILD", "build"), "bin", "anatomy")
ANATOMIES = os.path.join(ROOT, "shared", "examples", "anatomies")
ARCH_MM = 150  # every point of the arch lies higher than this
COARSE_MM = "3"  # spacing of the lumen's grid, which the centrelines do not depend on


def centreline(folder, name):
    """Returns the points (x, y, z, radius) of a vessel in mm; the files have the axes left, posterior, superior."""
    with open(os.path.join(folder, name + ".mrk.json"), encoding="utf-8") as file:
        markup = json.load(file)["markups"][0]
    radii = next(one for one in markup["measurements"] if one["name"] == "Radius")["controlPointValues"]
    places = [point["position"] for point in markup["controlPoints"]]
    return [(x, z, -y, radius) for (x, y, z), radius in zip(places, radii)]


def widths_below_the_top(name):
    """Returns how far the origin of the brachiocephalic artery lies below the top of the arch, in widths of the left
    common carotid artery."""
    with tempfile.TemporaryDirectory() as folder:
        words = [PROGRAM, "aorta", "--vessels", os.path.join(ANATOMIES, name + ".toml"), "--no-bodies", "--quiet"]
        subprocess.run(words + ["--lumen-mm", COARSE_MM, "-o", folder], check=True, stdout=subprocess.DEVNULL)
        aorta = centreline(folder, "aorta")
        branch = centreline(folder, "brachiocephalic_artery")
        width_mm = 2 * centreline(folder, "left_common_carotid_artery")[0][3]
    top_mm = max(y + radius for _, y, _, radius in aorta if y > ARCH_MM)
    origin_mm = next(point[1] for point in branch if all(math.dist(point[:3], other[:3]) > other[3] for other in aorta))
    widths = (top_mm - origin_mm) / width_mm
    print("# %s: %.2f widths" % (name, widths))
    return widths


def the_shipped_aorta_has_an_arch_of_type_I():
    return 0 < widths_below_the_top("aorta") < 1


def arch_type_2_has_an_arch_of_type_II():
    return 1 < widths_below_the_top("arch_type_2") < 2


def arch_type_3_has_an_arch_of_type_III():
    return widths_below_the_top("arch_type_3") > 2


if __name__ == "__main__":
    tap.run(
        [
            the_shipped_aorta_has_an_arch_of_type_I,
            arch_type_2_has_an_arch_of_type_II,
            arch_type_3_has_an_arch_of_type_III,
        ]
    )
