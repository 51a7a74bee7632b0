#!/usr/bin/env python3
"""Tests the files of vessels. The shipped files of vessels are valid. If a vessel's point is moved in the file, the
resulting vessel moves too. For each mistake in a file of vessels, the program refuses the file and names
file, line and key. The program either reads or refuses a damaged file, and it never crashes. Prints TAP."""

import json
import os
import random
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "check")]
import tree  # noqa: E402

BUILD = os.environ.get("BUILD", "build")
PROGRAM = os.path.join(ROOT, BUILD, "bin", "anatomy")
SHIPPED = os.path.join(ROOT, "shared", "examples", "anatomies")
DAMAGED = 150

OWN = """format = 1
title = "A pipe with a branch"
frame = "phantom"
fillet_mm = 2
[sources]
own = "own choice"
[entry]
vessel = "pipe"
from_end_mm = 20
[[vessel]]
name = "pipe"
stations = [
    { position_mm = [0, 100, 0], diameter_mm = 20, name = "top", source = "@own" },
    { position_mm = [0, 0, 0], diameter_mm = 16, name = "bottom", source = "@own: narrower" },
]
[[vessel]]
name = "branch"
parent = "pipe"
flow_ml_min = { value = 300, source = "@own" }
stations = [
    { position_mm = [0, 50, 0], diameter_mm = 6 },
    { position_mm = [40, 30, 0], diameter_mm = 5, name = "end", source = "a guess" },
]
"""
EXTENDING = """format = 1
extends = "shipped:aorta.toml"
title = "Mine"
[[vessel]]
name = "left renal artery"
replaces = true
parent = "aorta"
stations = [
    { position_mm = [5, -44, 0], diameter_mm = 6.3 },
    { position_mm = [34, -60, -15], diameter_mm = 6.1, name = "left renal", source = "moved by 11 mm" },
]
"""
RIGHT_MAIN = """format = 1
extends = "shipped:heart.toml"
title = "Every coronary artery on the right side"
[[coronary]]
name = "LM"
replaces = true
parent = "aorta"
side = "right"
stations = [
    { position_mm = [6, 151, 18], diameter_mm = 4.8 },
    { position_mm = [29, 138.5, 14.5], diameter_mm = 4.2 },
]
"""
HEART = """format = 1
extends = "shipped:aorta.toml"
title = "One coronary artery"
coronary_fillet_mm = 1
[[coronary]]
name = "RCA"
parent = "aorta"
side = "right"
stations = [
    { position_mm = [0, 151, 22], diameter_mm = 4.2 },
    { position_mm = [-9, 143, 39], diameter_mm = 3.95 },
    { height = 0.96, angle_deg = 345, diameter_mm = 3.9 },
    { height = 1.0, angle_deg = 322 },
    { height = 0.9, angle_deg = 300, diameter_mm = 3 },
]
"""
# Each entry has a valid file's text, the words to replace, the new words, and expected words of the error message.

# In the expected words, "LINE" or "LINE #" stands for the file's name and the line of the replaced words.
MISTAKES = (
    (OWN, "fillet_mm", "filet_mm", "LINE:12: unknown key 'filet_mm', did you mean 'fillet_mm'?"),
    (OWN, "format = 1", "format = 2", "LINE:10: 'format' must be 1; this file is of another version"),
    (OWN, "format = 1\n", "", "'format' is missing"),
    (OWN, 'title = "A pipe with a branch"\n', "", "'title' is missing"),
    (OWN, "with a branch", 'with a \\"branch\\"', "LINE:9: 'title' must have no quotes"),
    (OWN, "with a branch", "with a\\u001b branch", "LINE:9: 'title' holds a control character"),
    (OWN, "A pipe with a branch", "pipe" * 30, "LINE:9: 'title' is longer than 80 bytes"),
    (OWN, '"phantom"', '"fantom"', "LINE:9: 'frame' is 'fantom', did you mean 'phantom'?"),
    (OWN, 'frame = "phantom"\n', "", "'frame' is missing"),
    (OWN, "fillet_mm = 2", "fillet_mm = nan", "LINE:13: 'fillet_mm' is not a finite number"),
    (OWN, "fillet_mm = 2", "fillet_mm = -1", "LINE:13: 'fillet_mm' = -1 is outside 0 .. 10"),
    (OWN, 'own = "own choice"', 'own = "own choice"\nother = "x"', "7:9: no value names the source 'other'"),
    (OWN, '"@own"', '"@onw"', "there is no 'onw' in [sources], did you mean 'own'?"),
    (OWN, 'source = "a guess"', 'source = ""', "station 2: 'source' is empty"),
    (OWN, ', name = "end"', "", "vessel 'branch', station 2: 'source' without 'name'"),
    (OWN, ', source = "a guess"', "", "vessel 'branch', station 2: 'source' is missing"),
    (OWN, 'vessel = "pipe"', 'vessel = "pip"', "entry: there is no vessel 'pip', did you mean 'pipe'?"),
    (OWN, "from_end_mm = 20", "from_end_mm = 200", "entry: 'pipe' does not pass this place: it is 100.0 mm long"),
    (OWN, "from_end_mm = 20", "y_mm = -5", "entry: 'pipe' does not pass this place"),
    (OWN, "from_end_mm = 20", "y_mm = 5\nfrom_end_mm = 20", "entry: needs either 'y_mm' or 'from_end_mm'"),
    (OWN, '[entry]\nvessel = "pipe"\nfrom_end_mm = 20\n', "", "'entry' is missing"),
    (OWN, 'name = "branch"', 'name = "pipe"', "vessel 'pipe': there is a vessel of this name already, "),
    (OWN, 'name = "branch"', 'name = "../branch"', "LINE:8: [[vessel]]: 'name' must begin with a letter"),
    (OWN, '[[vessel]]\nname = "branch"\n', "[[vessel]]\n", "LINE:1: [[vessel]]: 'name' is missing"),
    (OWN, 'parent = "pipe"\n', "", "vessel 'branch': 'parent' is missing"),
    (OWN, 'parent = "pipe"', 'parent = "pipes"', "there is no vessel 'pipes' before this one, did you mean 'pipe'?"),
    (OWN, 'parent = "pipe"', 'parent = "branch"', "vessel 'branch': is its own 'parent'"),
    (OWN, 'name = "pipe"\nst', 'name = "pipe"\nparent = "branch"\nst', "is the first vessel, where blood enters"),
    (OWN, 'name = "pipe"\nst', 'name = "pipe"\nlumen = false\nst', "blood enters here, so it needs a lumen"),
    (OWN, 'parent = "pipe"', 'parent = "pipe"\ntissue = "gut"', "'tissue' belongs to a vessel with lumen = false"),
    (OWN, 'parent = "pipe"', 'parent = "pipe"\nlumen = false\ntissue = "guts"', "did you mean 'gut'?"),
    (OWN, "value = 300", "value = 3e9", "LINE:15: vessel 'branch': 'flow_ml_min' = 3e+09 is outside 0.1 .. 10000"),
    (OWN, '{ value = 300, source = "@own" }', "300", "LINE:15: vessel 'branch': 'flow_ml_min' must be { value"),
    (OWN, "{ position_mm = [0, 50, 0], diameter_mm = 6 },", "", "has 1 stations: give 2 to 200"),
    (
        OWN,
        "[0, 50, 0]",
        "[0, 50]",
        "vessel 'branch', station 1: 'position_mm' must be three numbers from -1000 to 1000",
    ),
    (OWN, "[0, 50, 0]", "[0, inf, 0]", "station 1: 'position_mm' must be three numbers"),
    (OWN, "[0, 50, 0]", '[0, "50", 0]', "station 1: 'position_mm' must be three numbers"),
    (OWN, "[0, 50, 0]", "[0, 5000, 0]", "LINE:21: vessel 'branch', station 1: 'position_mm' must be three numbers"),
    (OWN, "[0, 50, 0]", "[15, 50, 0]", "vessel 'branch': begins 6.0 mm outside of its parent 'pipe'"),
    (OWN, "[40, 30, 0]", "[0, 50, 0.1]", "station 2: is 0.1 mm from the station before it, less than 0.5"),
    (OWN, "diameter_mm = 5,", "diameter_mm = 0,", "station 2: 'diameter_mm' = 0 is outside 1 .. 60"),
    (OWN, ", diameter_mm = 6 }", " }", "station 1: 'diameter_mm' is missing"),
    (OWN, "diameter_mm = 6 }", "height = 0.5 }", "station 1: unknown key 'height'"),
    (OWN, "[[vessel]]", "[vessel]", ""),
    (OWN, "stations = [", "stations = 3 #[", ""),
    (OWN, OWN[OWN.index("[sources]") :], "[entry]\nvessel = 'pipe'\ny_mm = 1\n", "has no vessel"),
    (OWN, "fillet_mm = 2", "fillet_mm = 2\ncoronary_fillet_mm = 1", "'coronary_fillet_mm' without a [[coronary]]"),
    (EXTENDING, "aorta.toml", "aortic.toml", "LINE:11: there is no file aortic.toml in shared/examples/anatomies"),
    (EXTENDING, "shipped:aorta.toml", "shipped:../sessions/demo.session", "'extends' has a path behind 'shipped:'"),
    (EXTENDING, "shipped:aorta.toml", "shipped:aort.toml", "anatomies, did you mean 'aorta.toml'?"),
    (EXTENDING, "shipped:aorta.toml", "gone.toml", "LINE:11: 'extends' names "),
    (EXTENDING, "left renal artery", "left_renal_artery", "replaces 'left renal artery': spell the name like that"),
    (
        EXTENDING,
        'name = "left renal artery"\nreplaces = true\nparent = "aorta"',
        'name = "brachiocephalic artery"\nreplaces = true\nparent = "right subclavian artery"',
        "'parent': 'right subclavian artery' comes after this vessel: put the parent first",
    ),
    (EXTENDING, "shipped:aorta.toml", "bad.toml", "over 8 files extend each other: is there a circle?"),
    (EXTENDING, "format = 1", 'format = 1\nframe = "patient"', "'frame' is that of the file in 'extends'"),
    (EXTENDING, "replaces = true", "", "; to replace it, write replaces = true"),
    (EXTENDING, "replaces = true", 'replaces = "yes"', "'replaces' must be true or false"),
    (EXTENDING, "left renal artery", "left renal", "vessel 'left renal': replaces no vessel; known: aorta"),
    (EXTENDING, "[5, -44, 0]", "[200, -44, 0]", "station 1: 'position_mm' is outside of the patient's skin"),
    (EXTENDING, "[5, -44, 0]", "[5, -14, 30]", "mm outside of its parent 'aorta'"),
    (HEART, 'side = "right"', 'side = "rihgt"', "'side' is 'rihgt', did you mean 'right'?"),
    (HEART, 'side = "right"\n', "", "vessel 'RCA': 'side' is missing"),
    (HEART, "coronary_fillet_mm = 1\n", "", "'coronary_fillet_mm' is missing"),
    (HEART, "angle_deg = 345", "angle_deg = -15", "'angle_deg' turns by 337 degrees, more than 90"),
    (HEART, "height = 0.96", "height = 1.3", "station 3: 'height' = 1.3 is outside 0 .. 1.2"),
    (HEART, "angle_deg = 345, ", "", "station 3: 'angle_deg' is missing"),
    (HEART, "height = 1.0, ", "", "station 4: needs 'position_mm', or 'height' and 'angle_deg'"),
    (HEART, "{ height = 1.0, angle", "{ position_mm = [0, 151, 22], angle", "has both 'position_mm' and 'height'"),
    (HEART, "angle_deg = 300, diameter_mm = 3 ", "angle_deg = 300 ", "first and the last station on the heart need"),
    (HEART, "height = 1.0, angle_deg = 322", "position_mm = [-9, 141, 39], diameter_mm = 3", "positions come first"),
    (HEART, "{ height = 0.96", "#{ height = 0.96", "the first and the last station on the heart need"),
    (HEART, 'extends = "shipped:aorta.toml"', 'extends = "shipped:phantom.toml"', 'needs frame = "patient"'),
    (HEART, "[[coronary]]", "[[coronary]]\nreplaces = true", "vessel 'RCA': replaces no vessel"),
)


class Bench:
    def __init__(self, report, folder):
        self.report, self.folder = report, folder

    def run(self, *words, cwd=ROOT, program=PROGRAM):
        done = subprocess.run(
            [program, *words], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120, check=False
        )
        return done.returncode, done.stdout.decode(errors="replace")

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def ends(self, name, code, words, *command, **more):
        got, said = self.run(*command, **more)
        self.report.check(name, [] if got == code and words in said else ["exit %d: %s" % (got, said)])


def check_shipped(bench):
    for name in sorted(os.listdir(SHIPPED)):
        bench.ends("%s ships and is valid" % name, 0, "\t", "list", os.path.join(SHIPPED, name))
    bench.ends("the program finds what ships from any folder", 0, "infrarenal aorta", "list", cwd=bench.folder)
    for folder in ("bin", "share/cournand/examples"):
        os.makedirs(os.path.join(bench.folder, "prefix", folder))
    installed = shutil.copy(PROGRAM, os.path.join(bench.folder, "prefix", "bin"))
    bench.ends("where it is not installed, it says so", 1, "make install", "list", cwd="/", program=installed)
    shutil.copytree(SHIPPED, os.path.join(bench.folder, "prefix", "share/cournand/examples/anatomies"))
    bench.ends("an installed program finds what ships", 0, "proximal LAD", "list", "heart", cwd="/", program=installed)


def centreline(folder, name):
    with open(os.path.join(folder, name + ".mrk.json"), encoding="utf-8") as file:
        markup = json.load(file)["markups"][0]
    return [point["position"] for point in markup["controlPoints"]]


def check_moved(bench):
    """Checks that the centreline goes through the place of the moved station, and that other vessels do not change."""
    mine, out = bench.write("mine.toml", EXTENDING), os.path.join(bench.folder, "mine")
    plain = os.path.join(bench.folder, "plain")
    options = ("--no-bodies", "--quiet", "--lumen-mm", "2")
    bench.ends("a user's file is made", 0, "10 centrelines", "aorta", "--vessels", mine, "-o", out, *options)
    bench.ends("the shipped file is made", 0, "10 centrelines", "aorta", "-o", plain, *options)
    station = [34, 15, -60]  # LPS: +x, -z, +y
    for folder, is_moved in ((out, True), (plain, False)):
        points = centreline(folder, "left_renal_artery")
        bench.report.check(
            "a moved station moves its vessel" if is_moved else "without it the vessel runs elsewhere",
            [] if (station in points) == is_moved else [str(points)],
        )
    same = centreline(out, "right_renal_artery") == centreline(plain, "right_renal_artery")
    bench.report.check("the other vessels stay", [] if same else ["the right renal artery differs"])
    with open(os.path.join(out, "scene.toml"), encoding="utf-8") as file:
        scene = file.read()
    bench.report.check(
        "the scene has the user's title and names the file",
        [] if 'name = "Mine"' in scene and "--vessels " + mine in scene else [scene],
    )
    bench.ends("the list has the user's source", 0, "left renal\t6.10\t34.0\t-60.0\t-15.0", "list", mine)


def check_kinds(bench):
    own, out = bench.write("own.toml", OWN), os.path.join(bench.folder, "no")
    heart = bench.write("heart.toml", HEART)
    made = os.path.join(bench.folder, "own")
    fast = ("--quiet", "--lumen-mm", "2", "--body-scale", "4")
    bench.ends("a file without the shipped one is made", 0, "3 bodies", "phantom", "--vessels", own, "-o", made, *fast)
    for kind, file, words in (
        ("aorta", own, "is in the frame of a phantom"),
        ("heart", own, "is in the frame of a phantom"),
        ("aorta", heart, "has coronary arteries, which beat"),
        ("phantom", heart, "has coronary arteries, which beat"),
        ("heart", heart, "has no [[coronary]] of the left side"),
    ):
        bench.ends(
            "%s refuses a file that does not suit it: %s" % (kind, words), 2, words, kind, "--vessels", file, "-o", out
        )
    thin = bench.write("thin.toml", OWN.replace("diameter_mm = 6 }", "diameter_mm = 1.2 }"))
    words = "'branch' is 1.2 mm wide, too narrow for a grid of 0.8 mm: give --lumen-mm 0.69"
    bench.ends("a vessel that the grid would miss is refused", 2, words, "access", "--vessels", thin, "-o", out)
    right = bench.write("right.toml", RIGHT_MAIN)
    words = "has no [[coronary]] of the left side"
    bench.ends("branches follow the side of a replaced artery", 2, words, "heart", "--vessels", right, "-o", out)
    words = "--lesion excludes --heart-only"
    lesion = ("--heart-only", "--lesion", "LAD:75:14:22")
    bench.ends("a heart without a scene takes no lesion", 2, words, "heart", *lesion, "-o", out)
    bench.ends("an absent file is named", 1, "gone.toml: no such file", "aorta", "--vessels", "gone.toml", "-o", out)
    bench.ends("a folder is no file", 1, "no such file: give a file of vessels", "list", bench.folder + "/")
    bench.ends("an empty name is refused as usage", 2, "is empty", "aorta", "--vessels", "", "-o", out)
    bench.ends("a mistyped anatomy has a suggestion", 2, "did you mean 'phantom'?", "list", "phantm")
    bench.report.check("what is refused has written nothing", [] if not os.path.exists(out) else [out])


def check_mistakes(bench):
    for text, old, new, words in MISTAKES:
        assert old in text, old
        path = bench.write("bad.toml", text.replace(old, new, 1))
        line = text[: text.index(old)].count("\n") + 1
        words = words.replace("LINE", "%s:%d" % (path, line))
        code, said = bench.run("list", path)
        is_good = code == 1 and words in said and said.startswith("anatomy: ") and said.count("\n") == 1
        bench.report.check(
            "refused: %s" % (words or new.splitlines()[0]).replace(bench.folder + "/", ""),
            []
            if is_good and (path in said or "shipped" in words or "in shared" in words or "gone" in words)
            else [said],
        )


def damaged(text, dice):
    """Returns the text of a vessel file with random damage: lines or letters are removed, doubled or changed."""
    for _ in range(dice.randint(1, 4)):
        lines = text.split("\n")
        at = dice.randrange(len(lines))
        kind = dice.randrange(5)
        if kind == 0:
            del lines[at]
        elif kind == 1:
            lines.insert(at, lines[dice.randrange(len(lines))])
        elif kind == 2 and lines[at]:
            column = dice.randrange(len(lines[at]))
            lines[at] = lines[at][:column] + dice.choice("[]{}\"'#=,.-9e@\\\x00é") + lines[at][column + 1 :]
        elif kind == 3:
            number = dice.choice(("-1", "0", "1e308", "-1e-308", "nan", "inf", "9999999999999999999", "true", '""'))
            words = lines[at].split(" ")
            words[dice.randrange(len(words))] = number
            lines[at] = " ".join(words)
        else:
            lines = lines[:at]
        text = "\n".join(lines) or "\n"
    return text


def check_damaged(bench):
    """Checks that the program reads a damaged file or refuses it with a message, and does not crash."""
    dice = random.Random(21)
    texts = [
        OWN,
        EXTENDING,
        HEART,
        tree.read("shared/examples/anatomies/heart.toml").replace('"aorta', '"shipped:aorta'),
    ]
    faults = []
    for _ in range(DAMAGED):
        path = bench.write("damaged.toml", damaged(dice.choice(texts), dice))
        code, said = bench.run("list", path)
        if code not in (0, 1) or (code == 1 and not said.startswith("anatomy: ")):
            faults.append("exit %d: %s\n%s" % (code, said, open(path, encoding="utf-8").read()))
    bench.report.check("%d damaged files are read or refused in words" % DAMAGED, faults)
    path = bench.write("deep.toml", "format = " + "[" * 100000)
    bench.ends("deep brackets are refused", 1, "over 32 brackets", "list", path)


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(report, folder)
        for check in (check_shipped, check_moved, check_kinds, check_mistakes, check_damaged):
            check(bench)
    report.end()


if __name__ == "__main__":
    main()
