"""Plays an angioplasty with simulated hands of experts and novices (`cournand run --hands`), for tests that compare the
two groups with published studies.

The scene is a straight artery of 3 mm diameter with a side branch and a lesion, which can be simulated quickly. All
simulated people play the same script; the model `host/script/hand_model.cpp` makes their hands, feet and eyes differ.
"""

import json
import math
import os
import statistics
import subprocess

BUILD = os.environ.get("BUILD", "build")
EXAMPLES = "shared/examples"

SCRIPT = """\
begin wire inserted 20 mm
begin catheter inserted 5 mm
begin guide inserted 3 mm
field 20 cm
table y 50 mm
fluoro on rate 7.5 p/s
advance wire until inserted 60 mm at 30 mm/s
rotate wire 40 deg
table y 110 mm
advance wire until inserted 110 mm at 25 mm/s
rotate wire -40 deg
advance wire until inserted 170 mm at 25 mm/s
fluoro off
wait 0.5 s
cine on
wait 0.3 s
inject 2 ml at 3 ml/s
wait 1.2 s
cine off
fluoro on
advance catheter until inserted 129 mm at 40 mm/s
inflate to 8 bar at 4 bar/s
wait 1 s
deflate at 8 bar/s
withdraw catheter until inserted 30 mm at 80 mm/s
fluoro off
withdraw catheter until inserted 2 mm at 50 mm/s
load stent
fluoro on
advance catheter until inserted 129 mm at 40 mm/s
inflate to 14 bar at 4 bar/s
wait 1.5 s
deflate at 8 bar/s
withdraw catheter until inserted 60 mm at 60 mm/s
fluoro off
cine on
wait 0.3 s
inject 2 ml at 3 ml/s
wait 1.2 s
cine off
wait 0.2 s
"""

SCENE = """\
[scene]
name = "Artery with a side branch"
[lumen]
centrelines = ["artery.csv"]
surface_mm = 0.4
tolerance_mm = 0.05
level_max = 2
[tree]
centrelines = ["artery.csv"]
inlet = "artery"
flow_ml_min = { artery = 60, side = 20 }
[entry]
position_mm = [0, 5, 0]
direction = [0, 1, 0]
[[body]]
name = "lumen"
mesh = "lumen"
material = "blood"
[[lesion]]
name = "plaque"
branch = "artery"
at_mm = 120
length_mm = 12
stenosis_percent = 70
yield_kPa = 300
full_kPa = 300
recoil = 0.1
"""

PLAN_WORDS = ["--plan", "angioplasty", "--vessel", "target=artery"]


def write_scene(folder):
    """Bakes the scene in the folder and returns its path."""
    rows = ["branch,name,x_mm,y_mm,z_mm,radius_mm"]
    rows += [f"0,artery,0,{y},0,1.5" for y in range(0, 211, 15)]
    rows += [f"1,side,{0.64 * s:.2f},{60 + 0.77 * s:.2f},0,1.1" for s in range(0, 65, 8)]
    for name, text in (("artery.csv", "\n".join(rows) + "\n"), ("scene.toml", SCENE), ("a.session", SCRIPT)):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(text)
    scene = os.path.join(folder, "a.scene")
    words = [f"{BUILD}/bin/bake", os.path.join(folder, "scene.toml"), "-o", scene, "--points", "1000", "--poses", "0"]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return scene


def play(folder, scene, skill, seed):
    """Plays the script with the hands of one person, and returns the report with its assessment."""
    report = os.path.join(folder, f"{skill}_{seed}.json")
    words = [
        f"{BUILD}/bin/cournand",
        "run",
        "--quiet",
        "--scene",
        scene,
        "--session",
        os.path.join(folder, "a.session"),
    ]
    for tool in ("coronary_014", "balloon_3x20", "guide_ntr_6f"):
        words += ["--tool", f"{EXAMPLES}/instruments/{tool}.toml"]
    words += ["--stent", f"{EXAMPLES}/stents/coronary_3_0x18.toml", "--hands", f"{skill}:{seed}", "--json", report]
    done = subprocess.run(words + PLAN_WORDS, check=False, capture_output=True, text=True)
    if not os.path.exists(report):
        raise RuntimeError(f"{skill}:{seed}: {done.stderr}")
    with open(report, encoding="utf-8") as file:
        return json.load(file)


def figures(report):
    """Returns what the studies compare: time, fluoroscopy, errors, phases, path of the tips, residual stenosis."""
    assessment = report["assessment"]
    metrics = {metric["name"]: metric["value"] for metric in assessment["metrics"]}
    phases = [phase for phase in assessment["phases"] if phase["why_not"] is None]
    steps = [step for phase in phases for step in phase["steps"] if step["why_not"] is None]
    return {
        "time_s": report["ticks"] * 1e-3,
        "fluoroscopy_s": metrics["fluoroscopy_min"] * 60.0,
        "errors": len(assessment["errors"]),
        "phases": sum(phase["end_tick"] is not None for phase in phases),
        "steps": sum(step["done_tick"] is not None for step in steps),
        "path_px": sum(tool["tip_path_px"] for tool in assessment["tools"]),
        "path_mm": sum(tool["tip_path_mm"] for tool in assessment["tools"]),
        "submovements": sum(tool["submovements"] for tool in assessment["tools"]),
        "sparc": assessment["tools"][0]["sparc"],
        "stenosis_pct": metrics["residual_stenosis_pct"],
        "percent": assessment["score"]["percent"],
    }


def group(folder, scene, skill, seeds):
    """Plays the script once for each seed and returns, for each measure, a list with one value per seed."""
    people = [figures(play(folder, scene, skill, seed)) for seed in seeds]
    return {name: [person[name] for person in people] for name in people[0]}


def median_ratio(novices, experts, name):
    return statistics.median(novices[name]) / statistics.median(experts[name])


def auc(larger, smaller):
    """Returns the probability that a value of the first list is larger than a value of the second list; equal values
    count half."""
    wins = sum((a > b) + 0.5 * (a == b) for a in larger for b in smaller)
    return wins / (len(larger) * len(smaller))


def mann_whitney_p(a, b):
    """Returns the two-sided p value of the Mann-Whitney test, by its normal approximation with the correction for
    ties."""
    values = sorted(a + b)
    n, ties = len(values), [values.count(value) for value in set(values)]
    spread = len(a) * len(b) / 12.0 * (n + 1 - sum(t**3 - t for t in ties) / (n * (n - 1)))
    if spread == 0.0:
        return 1.0
    z = (abs(auc(a, b) - 0.5) * len(a) * len(b) - 0.5) / math.sqrt(spread)
    return math.erfc(max(0.0, z) / math.sqrt(2.0))
