#!/usr/bin/env python3
"""Samples the persons of `anatomy person` in the long part of the tests: 500 seeds keep the rules, and two whole
persons, with meshes, are baked without a warning. SEEDS and PERSONS change how many. Prints TAP."""

import os
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "check")]
import tap  # noqa: E402

BIN = os.path.join(ROOT, os.environ.get("BUILD", "build"), "bin")
SEEDS = os.environ.get("SEEDS", "500")
PERSONS = int(os.environ.get("PERSONS", "2"))


def run(name, *words):
    return subprocess.run([os.path.join(BIN, name), *words], capture_output=True, text=True, check=False)


def every_seed_gives_a_person():
    checked = run("anatomy", "seeds", "--count", SEEDS, "--coronary")
    print("#", checked.stdout.strip().replace("\n", "\n# "))
    return checked.returncode == 0 and " 0 refused" in checked.stdout


def persons_are_baked_without_a_warning():
    """`bake` checks that every mesh is closed and that no body reaches out of the body around it. Every second person
    has the arms beside the body, and everything that may lie on or in a patient."""
    more = ["--arms", "beside", "--clutter", "leads,table,wires,pacemaker"]
    good = True
    for seed in range(PERSONS):
        with tempfile.TemporaryDirectory() as folder:
            extra = more if seed % 2 else []
            made = run("anatomy", "person", "--seed", str(seed), *extra, "--quiet", "-o", folder)
            scene = os.path.join(folder, "scene.toml")
            baked = run("bake", scene, "-o", os.path.join(folder, "x.scene"), "--points", "1000", "--poses", "0")
            text = baked.stdout + baked.stderr
            if made.returncode != 0 or baked.returncode != 0 or "warning" in text:
                print("# seed", seed, made.stderr, "\n#".join(line for line in text.splitlines() if "warning" in line))
                good = False
    return good


if __name__ == "__main__":
    tap.run([every_seed_gives_a_person, persons_are_baked_without_a_warning])
