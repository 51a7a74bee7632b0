#!/usr/bin/env python3
"""Tests the options by which `anatomy` makes random variants of the arteries from a seed. Prints TAP."""

import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "check")]
import tap  # noqa: E402

PROGRAM = os.path.join(ROOT, os.environ.get("BUILD", "build"), "bin", "anatomy")
COARSE = ["--no-bodies", "--quiet", "--lumen-mm", "2"]


def run(*words):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)


def read(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return file.read()


def the_scene_of_a_seed_comes_with_its_vessel_file():
    with tempfile.TemporaryDirectory() as folder:
        made = run("aorta", "--seed", "7", *COARSE, "-o", folder)
        drawn = run("draw", "--seed", "7", "-o", os.path.join(folder, "drawn.toml"))
        same = read(folder, "vessels.toml") == read(folder, "drawn.toml")
        scene = read(folder, "scene.toml")
        return made.returncode == drawn.returncode == 0 and same and "anatomy aorta --seed 7" in scene


def a_drawn_file_makes_the_same_lumen_as_its_seed():
    with tempfile.TemporaryDirectory() as folder:
        file, one, other = (os.path.join(folder, name) for name in ("drawn.toml", "one", "other"))
        run("draw", "--seed", "8", "-o", file)
        codes = [run("aorta", "--seed", "8", *COARSE, "-o", one).returncode]
        codes.append(run("aorta", "--vessels", file, *COARSE, "-o", other).returncode)
        lumens = []
        for made in (one, other):
            with open(os.path.join(made, "lumen.ply"), "rb") as mesh:
                lumens.append(mesh.read())
        return codes == [0, 0] and len(lumens[0]) > 100_000 and lumens[0] == lumens[1]


def a_common_trunk_carries_the_left_carotid():
    """The tree of seed 7 has a common trunk: the centreline of the left carotid artery begins in the brachiocephalic
    artery."""
    with tempfile.TemporaryDirectory() as folder:
        made = run("aorta", "--seed", "7", *COARSE, "-o", folder)
        curves = {}
        for name in ("left_common_carotid_artery", "brachiocephalic_artery"):
            markup = json.loads(read(folder, name + ".mrk.json"))["markups"][0]
            curves[name] = [point["position"] for point in markup["controlPoints"]]
        start = curves["left_common_carotid_artery"][0]
        to_trunk_mm = min(
            sum((a - b) ** 2 for a, b in zip(start, point)) ** 0.5 for point in curves["brachiocephalic_artery"]
        )
        return made.returncode == 0 and to_trunk_mm < 1.5  # centreline points are about 1 mm apart


def wrong_seeds_and_outputs_are_refused():
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "drawn.toml")
        both = run("aorta", "--seed", "7", "--vessels", "my.toml", "-o", folder)
        negative = run("draw", "--seed", "-1", "-o", file)
        word = run("draw", "--seed", "seven", "-o", file)
        missing = run("draw", "-o", file)
        nowhere = run("draw", "--seed", "7", "-o", os.path.join(folder, "none", "drawn.toml"))
        lesion = run("aorta", "--seed", "7", "--lesion", "nothing:50:10:5", *COARSE, "-o", os.path.join(folder, "made"))
        codes = [one.returncode for one in (both, negative, word, missing, nowhere, lesion)]
        print("#", codes)
        return codes == [2, 2, 2, 2, 1, 2] and os.listdir(folder) == [] and "--seed" in missing.stderr


if __name__ == "__main__":
    tap.run(
        [
            the_scene_of_a_seed_comes_with_its_vessel_file,
            a_drawn_file_makes_the_same_lumen_as_its_seed,
            a_common_trunk_carries_the_left_carotid,
            wrong_seeds_and_outputs_are_refused,
        ]
    )
