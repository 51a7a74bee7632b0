#!/usr/bin/env python3
"""Tests `anatomy person` and `anatomy seeds`: what is drawn and what is asked for, their files, wrong options, and that
the number of threads changes no byte. Prints TAP."""

import csv
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "check"), os.path.dirname(os.path.abspath(__file__))]
import check_meshes  # noqa: E402
import tap  # noqa: E402

PROGRAM = os.path.join(ROOT, os.environ.get("BUILD", "build"), "bin", "anatomy")
COARSE = ["--no-bodies", "--quiet", "--lumen-mm", "2.4"]


def run(*words):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)


def read(*path):
    with open(os.path.join(*path), "rb") as file:
        return file.read()


def values(folder):
    """Returns the keys of person.toml."""
    return dict(re.findall(r"^(\w+) = ([^#\n]*?) *(?:#.*)?$", read(folder, "person.toml").decode(), re.M))


def person(folder, *words):
    made = run("person", *words, *COARSE, "-o", folder)
    return values(folder) if made.returncode == 0 else {"error": made.stderr}


def the_command_in_person_toml_makes_the_same_person():
    """Also the grid of the lumen, and a lesion."""
    with tempfile.TemporaryDirectory() as folder:
        one, other = os.path.join(folder, "one"), os.path.join(folder, "other")
        lesion = ["--lesion", "left_renal_artery:50:10:15"]
        person(one, "--seed", "5", "--sex", "f", "--age", "71", "--tortuosity", "1.2", *lesion)
        words = re.search(r"anatomy person (.*) -o FOLDER", read(one, "person.toml").decode())[1].split()
        run("person", *words, "--quiet", "-o", other)
        names = sorted(os.listdir(one))
        return len(names) > 5 and all(read(one, name) == read(other, name) for name in names)


def an_option_replaces_what_the_seed_draws_and_nothing_else():
    """Another weight changes neither sex, age, height nor arch, and --calcium only the calcium. Arms beside the body
    move the arteries of the arms, but neither the lumen nor the arteries of the head."""
    with tempfile.TemporaryDirectory() as folder:
        drawn = person(os.path.join(folder, "a"), "--seed", "3")
        heavy = person(os.path.join(folder, "b"), "--seed", "3", "--weight", "70", "--calcium", "0.5")
        changed = {key for key in drawn if drawn[key] != heavy.get(key)}
        print("#", drawn, changed)
        if heavy["weight_kg"] != "70" or changed != {"weight_kg", "fat", "belly_mm", "wall_calcium"}:
            return False
        lowered = person(os.path.join(folder, "c"), "--seed", "3", "--arms", "beside", "--clutter", "leads,wires")
        lines = [read(folder, name, "small_vessels.csv").decode().splitlines() for name in "ac"]
        moved = {line.split(",")[0] for line in set(lines[0]) - set(lines[1])}
        print("#", moved)
        return (
            lowered["arms"] == '"beside"'
            and read(folder, "a", "lumen.ply") == read(folder, "c", "lumen.ply")
            and "left_radial_artery" in moved
            and "left_internal_carotid_artery" not in moved
        )


def age_widens_the_arch_and_height_scales_the_tree():
    """The published mean widths are 71 and 93 mm below 45 and above 65 years (men). Both seeds are the same, so the
    widths that are asked for differ by those 22 mm; the trees have them within 12 mm, because each tree also varies by
    itself (measured: 1 and 4 mm). Heights of 1.60 and 1.90 m differ by 190/160 in scale."""
    with tempfile.TemporaryDirectory() as folder:
        young = person(os.path.join(folder, "a"), "--seed", "4", "--sex", "m", "--age", "30", "--height", "160")
        old = person(os.path.join(folder, "b"), "--seed", "4", "--sex", "m", "--age", "80", "--height", "190")
        widths = [float(one["arch_width_mm"]) for one in (young, old)]
        wanted = [float(one["arch_width_drawn_mm"]) for one in (young, old)]
        ratio = float(old["scale"]) / float(young["scale"])
        print("# widths", widths, "asked for", wanted, "ratio of scales", ratio)
        if abs(wanted[1] - wanted[0] - 22) > 0.15:  # two values rounded to 0.1 mm
            return False
        return all(abs(a - b) < 12 for a, b in zip(widths, wanted)) and abs(ratio - 190 / 160) < 1e-3


def the_vessels_of_a_person_can_be_read_back():
    with tempfile.TemporaryDirectory() as folder:
        person(folder, "--seed", "6")
        listed = run("list", os.path.join(folder, "vessels.toml"))
        return listed.returncode == 0 and "ascending aorta" in listed.stdout


def vertices_of(folder):
    return check_meshes.read_ply(pathlib.Path(folder) / "lumen.ply")[0]


def courses_of(folder):
    """Returns for each small artery with a name every 4th place of its course, with the radius."""
    with open(os.path.join(folder, "small_vessels.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    courses = {}
    for row in rows:
        if "vein" not in row["vessel"] and not row["vessel"].isdigit():
            place = tuple(float(row[axis]) for axis in ("x_mm", "y_mm", "z_mm"))
            courses.setdefault(row["vessel"], []).append((place, float(row["radius_mm"])))
    return {name: places[::4] for name, places in courses.items()}


def nearest_mm(place, vertices):
    return min(math.dist(place, vertex) for vertex in vertices)


def small_arteries_from_a_diameter_on_are_a_part_of_the_lumen():
    """With --lumen-from 4.2, the wall of the lumen lies at the radius of each course of 4.2 mm and more. Measured: the
    nearest vertex is 0.93 mm nearer to 1.22 mm farther, because the grid has 2.4 mm. Nothing of the lumen is near the
    thinner arteries (measured: 4.1 mm)."""
    with tempfile.TemporaryDirectory() as folder:
        plain, wide = os.path.join(folder, "a"), os.path.join(folder, "b")
        person(plain, "--seed", "3")
        if "error" in person(wide, "--seed", "3", "--lumen-from", "4.2"):
            return False
        before, after = vertices_of(plain), vertices_of(wide)
        far = [
            (place, radius)
            for places in courses_of(plain).values()
            if places[0][1] > 1.0
            for place, radius in places
            if nearest_mm(place, before) > radius + 4
        ]
        inside = [point for point in far if point[1] >= 2.1]
        gaps = [nearest_mm(place, after) - radius for place, radius in inside]
        outside = [
            nearest_mm(place, after) - radius
            for place, radius in far
            if radius < 2.0 and all(math.dist(place, other) > 15 for other, _ in inside)
        ]
        print("# wall", len(gaps), min(gaps), max(gaps), "others", len(outside), min(outside))
        return len(gaps) > 60 and min(gaps) > -1.4 and max(gaps) < 1.8 and len(outside) > 400 and min(outside) > 3


def seeds_are_counted_and_none_is_refused():
    checked = run("seeds", "--from", "40", "--count", "5", "--coronary")
    print("#", checked.stdout)
    return checked.returncode == 0 and checked.stdout.startswith("seeds 40 to 44: 5 accepted, 0 refused")


def the_number_of_threads_changes_no_byte():
    with tempfile.TemporaryDirectory() as folder:
        for threads in ("1", "3"):
            made = run(
                "phantom", "--threads", threads, "--body-scale", "4", "--quiet", "-o", os.path.join(folder, threads)
            )
            if made.returncode != 0:
                return False
        names = sorted(os.listdir(os.path.join(folder, "1")))
        return len(names) > 5 and all(read(folder, "1", name) == read(folder, "3", name) for name in names)


def wrong_options_are_refused_with_their_range():
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "x")
        cases = [
            (["--seed", "1", "--age", "7"], "--age: Value 7 not in range"),
            (["--seed", "1", "--sex", "x"], "--sex"),
            (["--seed", "1", "--arch", "IV"], "--arch"),
            (["--seed", "1", "--clutter", "leads,tabel"], "did you mean 'table'"),
            (["--seed", "1", "--height", "170", "--weight", "170"], "choose --weight 47 to 121"),
            (["--age", "50"], "--seed"),
            (["--seed", "1", "--lumen-from", "2"], "too narrow for a grid of 2.4 mm: give --lumen-mm 1.1"),
            (["--seed", "1", "--vessels", "my.toml"], "--vessels"),
        ]
        good = True
        for words, text in cases:
            made = run("person", *words, *COARSE, "-o", out)
            if made.returncode != 2 or text not in made.stderr:
                print("#", words, made.returncode, made.stderr)
                good = False
        return good and not os.path.exists(out)


if __name__ == "__main__":
    tap.run(
        [
            the_command_in_person_toml_makes_the_same_person,
            an_option_replaces_what_the_seed_draws_and_nothing_else,
            age_widens_the_arch_and_height_scales_the_tree,
            the_vessels_of_a_person_can_be_read_back,
            small_arteries_from_a_diameter_on_are_a_part_of_the_lumen,
            seeds_are_counted_and_none_is_refused,
            the_number_of_threads_changes_no_byte,
            wrong_options_are_refused_with_their_range,
        ]
    )
