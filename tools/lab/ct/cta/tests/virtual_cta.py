"""Makes a person, a CT angiogram of this person, and a scene of the angiogram without a click; compares the scene's
centrelines and the forces of a session with the truth. The tests test_virtual_cta.py and test_ten_ctas.py import this
module; run as a program, it prints the rows of the seeds that are its arguments."""

import json
import os
import re
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, "..", "..", "..", "..", "check"), HERE]
import compare  # noqa: E402
import tree  # noqa: E402

BUILD = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"))
LEAST_RADIUS_MM, WIDE_RADIUS_MM = 1.0, 2.0
LIMIT_S = 1800
CLICKS_MAX = 5
BEGIN = "begin wire inserted %d mm"
STARTS_MM = (5, 6, 7, 8, 9, 10, 11, 12)
STARTS_LEAST = 6  # of them must end in both scenes
ENTRY = re.compile(r"position_mm = .*\ndirection = .*\n")


def run(program, *arguments):
    """Returns the processor time in seconds. A program that fails ends the test with its message."""
    before = os.times()
    done = subprocess.run(
        [os.path.join(BUILD, "bin", program)] + list(arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        timeout=LIMIT_S,
        check=False,
        cwd=tree.ROOT,
    )
    if done.returncode != 0:
        raise RuntimeError("%s %s: %s" % (program, arguments[0], (done.stderr or done.stdout)[-600:]))
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def tour_scene(made, person, target):
    """Bakes the lumen of a scene without bodies and motion, with the entry of the person: instruments enter both scenes
    at the same place."""
    with open(os.path.join(person, "scene.toml"), encoding="utf-8") as file:
        entry = ENTRY.search(file.read()).group(0)
    with open(os.path.join(made, "scene.toml"), encoding="utf-8") as file:
        text = ENTRY.sub(entry, file.read().split("[[body]]")[0])
    scene = os.path.join(made, "tour.toml")
    with open(scene, "w", encoding="utf-8") as file:
        file.write(re.sub(r"\n\[motion\][^\[]*", "\n", text))
    run("bake", scene, "-o", target)


def forces(scene):
    """Plays the tour from several starts, because the greatest force of one tour depends on chance: on where a tip
    catches. Returns for each start the force's integral over time in N s, the force that 95 % of the time stays below
    in N, and the greatest force in N; None where the wire was caught so that physics left its range."""
    with open(os.path.join(HERE, "tour.session"), encoding="utf-8") as file:
        tour = file.read()
    if BEGIN % STARTS_MM[0] not in tour:
        raise RuntimeError("tour.session has no line '%s'" % (BEGIN % STARTS_MM[0]))
    session, report, figures = scene + ".session", scene + ".json", []
    for start_mm in STARTS_MM:
        with open(session, "w", encoding="utf-8") as file:
            file.write(tour.replace(BEGIN % STARTS_MM[0], BEGIN % start_mm))
        options = ("--json", report, "--png", scene + ".png", "--quiet")
        try:
            run("cournand", "run", "--scene", scene, "--session", session, *options)
        except RuntimeError as error:
            if "physics left its range" not in str(error):
                raise
            figures.append(None)
            continue
        with open(report, encoding="utf-8") as file:
            contact = json.load(file)["contact"]
        ordered = sorted(contact["force_N"])
        figures.append((contact["impulse_N_s"], ordered[int(0.95 * len(ordered))], contact["force_max_N"]))
    return figures


def compared_forces(true_scene, found_scene):
    """Returns the number of starts whose tours end in both scenes, the three means over these in the true scene, and
    those in the found scene over them less 1."""
    pairs = [pair for pair in zip(forces(true_scene), forces(found_scene)) if None not in pair]
    if len(pairs) < STARTS_LEAST:
        raise RuntimeError("only %d of %d tours end in both scenes" % (len(pairs), len(STARTS_MM)))
    true, found = ([sum(column) / len(pairs) for column in zip(*figures)] for figures in zip(*pairs))
    return len(pairs), true, [f / t - 1 for f, t in zip(found, true)]


def row_of(seed, folder, options=(), clicks_max=0):
    """Returns the figures of one person, whose true lumen has all arteries that are compared. With clicks, arteries
    that were missed are clicked on, the longest first, each in the middle of what is missed: as a person does who
    compares the scan with the arteries that were found."""
    person, found = os.path.join(folder, "person"), os.path.join(folder, "found")
    scan, truth = os.path.join(folder, "cta.nii.gz"), os.path.join(folder, "truth.csv")
    os.makedirs(folder, exist_ok=True)
    run("anatomy", "person", "--seed", str(seed), "--lumen-from", str(2 * LEAST_RADIUS_MM), "-o", person)
    made_s = run("ct", "cta", person, "-o", scan, "--truth", truth, "--seed", str(seed), *options)
    begin = time.monotonic()
    cpu_s = run("ct", "patient", scan, "-o", found)
    true, tree_file = compare.read_truth(truth, LEAST_RADIUS_MM), os.path.join(found, "tree.csv")
    unaided = compare.summary(compare.compare(true, compare.read_tree(tree_file)))
    clicks = compare.missed(true, compare.read_tree(tree_file), clicks_max)
    if clicks:
        options = [word for _, _, place in clicks for word in ("--click", "artery:%.1f,%.1f,%.1f" % place)]
        cpu_s += run("ct", "patient", scan, "-o", found, *options)
    wall_s = time.monotonic() - begin
    rows = compare.compare(true, compare.read_tree(tree_file))
    for length_mm, name, place in clicks:
        share = next((row[2] for row in rows if row[0] == name), 0.0)
        print(
            "# seed %d: click on %s at %.1f,%.1f,%.1f: %d mm missed, then %.0f %% found"
            % ((seed, name) + place + (length_mm, 100 * share)),
            flush=True,
        )
    wide = [row for row in rows if row[5] >= WIDE_RADIUS_MM]
    scenes = [os.path.join(folder, name) for name in ("true.scene", "found.scene")]
    tour_scene(person, person, scenes[0])
    tour_scene(found, person, scenes[1])
    tours, true_force, force = compared_forces(*scenes)
    with open(os.path.join(folder, "vessels.json"), "w", encoding="utf-8") as file:
        json.dump(rows, file, indent=1)
    return {
        "seed": seed,
        "vessels": len(rows),
        "all": compare.summary(rows),
        "wide": compare.summary(wide),
        "wide_vessels": len(wide),
        "cta_s": made_s,
        "cpu_s": cpu_s,
        "wall_s": wall_s,
        "clicks": len(clicks),
        "unaided": unaided,
        "force": force,
        "true_force": true_force,
        "tours": tours,
    }


def text_of(row):
    """Returns the person's line of the table in docs/own_ct.md."""
    columns = ["%d" % row["seed"], "%d of %d" % (row["wide_vessels"], row["vessels"])]
    for found, apart_mm, radius in (row["wide"], row["all"]):
        columns += ["%.0f %%" % (100 * found), "%.2f mm" % apart_mm, "%.1f %%" % (100 * radius)]
    columns += [
        "%.0f %%, %d" % (100 * row["unaided"][0], row["clicks"]),
        "%.0f s" % row["cpu_s"],
        "%+.1f %%, %+.1f %%, %+.0f %%, %d" % (tuple(100 * f for f in row["force"]) + (row["tours"],)),
    ]
    return "| " + " | ".join(columns) + " |"


if __name__ == "__main__":
    for number in sys.argv[1:]:
        try:
            print(
                text_of(
                    row_of(
                        int(number),
                        os.path.join(BUILD, "virtual_cta", number),
                        ("--pixel-mm", "0.9", "--slice-mm", "1.25"),
                        CLICKS_MAX,
                    )
                ),
                flush=True,
            )
        except RuntimeError as error:
            print("| %s | %s |" % (number, error), flush=True)
