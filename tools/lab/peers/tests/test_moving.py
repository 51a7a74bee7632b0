#!/usr/bin/env python3
"""These tests check the comparison on a moving wire (tools/lab/peers/run_moving.py): the rules of its gate on made-up
figures, the geometry of its vessel against closed forms, our program on the task, and the whole script with small
programs in place of the simulators. Prints TAP."""

import math
import os
import subprocess
import sys
import tempfile

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.dirname(FOLDER), os.path.join(FOLDER, "..", "..", "..", "check")]
import moving_gate as gate  # noqa: E402
import moving_task as task  # noqa: E402
import run_moving  # noqa: E402
import tree  # noqa: E402

RUN_MOVING = os.path.join(tree.ROOT, "tools", "lab", "peers", "run_moving.py")
OURS = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"), "bench", "peer_moving")
GOOD = {"tip_mm": 1.0, "penetration_mm": 0.1, "length_error_pct": 0.5, "warnings": 0}


def equal(got, expected):
    return [] if got == expected else ["%r, expected %r" % (got, expected)]


def near(got, expected, tolerance):
    return [] if abs(got - expected) <= tolerance else ["%g, expected %g" % (got, expected)]


def row(peer, simulated_s, counts=True, faults=()):
    figures = {"simulated_s": simulated_s, "processor_s": 1.0}
    return {"peer": peer, "figures": figures, "counts": counts, "faults": faults}


def rules(report):
    report.check("figures at their limits are right", equal(gate.faults(GOOD), []))
    for name, limit in gate.LIMITS.items():
        above = gate.faults(dict(GOOD, **{name: limit + 1}))
        report.check("a figure above its limit is wrong: %s" % name, equal(above, [name]))
        report.check("no number is wrong: %s" % name, equal(gate.faults(dict(GOOD, **{name: math.nan})), [name]))
    missing = {key: value for key, value in GOOD.items() if key != "tip_mm"}
    report.check("without a reference run a setting is wrong", equal(gate.faults(missing), ["tip_mm"]))
    report.check("a setting can be wrong before its reference run", equal(gate.faults_alone(missing), []))
    setting = gate.chain(8, 0.02, damping_steps=2.0, twist_kg_m2=1e-3)
    divided = gate.reference(setting)
    ratios = {key: setting[key] / divided[key] for key in gate.DIVIDED}
    report.check("the reference run divides the step and its aids", equal(ratios, dict.fromkeys(gate.DIVIDED, 4.0)))
    report.check("and nothing else", equal(divided["integrator"], "discrete"))
    here, there = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]], [[0.0, 0.0, 0.0]] * 2
    report.check("the largest distance of two tips counts", equal(gate.tip_difference_mm(here, there), 5.0))
    report.check("a run that ended early is far away", equal(gate.tip_difference_mm(here, there[:1]), math.inf))
    report.check("no number is far away", equal(gate.tip_difference_mm(here, [[math.nan] * 3] * 2), math.inf))
    rows = [row("chain", 2.0), row("chain", 3.0), row("chain", 9.0, counts=False), row("chain", 8.0, faults=["tip_mm"])]
    report.check("the fastest right setting counts", equal(gate.fastest_right(rows, "chain"), rows[1]))
    report.check("a peer may have none", equal(gate.fastest_right(rows, "cathsim"), None))


def from_axis_m(point):
    """Returns the distance of a point from the vessel's axis, by the closed form of a line, an arc and a line."""
    x, y, z = point
    centre = (task.STRAIGHT_m, task.BEND_RADIUS_m)
    angle = math.atan2(x - centre[0], centre[1] - z)
    if angle <= 0:
        return math.hypot(y, z)
    if angle <= task.BEND_rad:
        return math.hypot(y, math.hypot(x - centre[0], z - centre[1]) - task.BEND_RADIUS_m)
    sine, cosine = math.sin(task.BEND_rad), math.cos(task.BEND_rad)
    end = (centre[0] + task.BEND_RADIUS_m * sine, centre[1] - task.BEND_RADIUS_m * cosine)
    return math.hypot(y, -(x - end[0]) * sine + (z - end[1]) * cosine)


def depth_m(point):
    """Returns how deep a point is inside the wall's boxes, negative outside of all (then only its sign is meant)."""
    deepest = -math.inf
    for place, along, outward, (half_along, half_across, half_out) in task.staves():
        offset = [p - q for p, q in zip(point, place)]
        a = sum(o * v for o, v in zip(offset, along))
        n = sum(o * v for o, v in zip(offset, outward))
        across = math.sqrt(max(0.0, sum(o * o for o in offset) - a * a - n * n))
        deepest = max(deepest, min(half_along - abs(a), half_across - across, half_out - abs(n)))
    return deepest


def in_bend(angle, across_m, up_m):
    """Returns the point that lies across_m beside the bend's axis and up_m from it towards the bend's centre."""
    reach = task.BEND_RADIUS_m - up_m
    return (task.STRAIGHT_m + reach * math.sin(angle), across_m, task.BEND_RADIUS_m - reach * math.cos(angle))


def circle_points(radius_m):
    """Returns points all along the bend, on circles around its axis."""
    angles = [k * task.BEND_rad / 200 for k in range(200)]
    return [in_bend(a, radius_m * math.cos(v), radius_m * math.sin(v)) for a in angles for v in range(7)]


def geometry(report):
    middles = [[p - (h[2]) * o for p, o in zip(place, outward)] for place, _, outward, h in task.staves()]
    largest = max(abs(from_axis_m(middle) - task.APOTHEM_m) for middle in middles)
    report.check("every stave's face touches a tube around the axis (to 0.1 mm)", near(largest, 0.0, 1e-4))
    count = task.STAVES * (task.BEND_PIECES + 2)
    report.check("the vessel has all its staves", equal(len(middles), count))
    inside = circle_points(3.3e-3)
    report.check("no box reaches into the lumen", equal([p for p in inside if depth_m(p) > 0], []))
    gaps = [p for p in circle_points(4.4e-3) if depth_m(p) < 0]
    report.check("the wall has no gap", equal(gaps, []))
    groove = (task.RADIUS_m - task.WIRE_RADIUS_m) * math.cos(math.pi / task.STAVES) + task.WIRE_RADIUS_m
    report.check("a wire in the groove lies where it would lie in a tube", near(groove, task.APOTHEM_m, 1e-12))


def our_run(report):
    figures, tips_mm = run_moving.ours(OURS)
    faults = gate.faults_alone(figures)
    report.check("our run of the task is within the limits that need no reference", equal(faults, []))
    report.check("the tip is noted at equal times", equal(len(tips_mm), task.SAMPLES))
    # Until it meets the bend's outside wall (at 51.9 mm) the wire is straight, and as long as it was fed.
    straight = [k for k in range(task.SAMPLES) if tips_mm[k][0] < 50]
    fed = [task.START_m * 1e3 + task.PUSH_m_per_s * 1e3 * task.DURATION_s / task.SAMPLES * (k + 1) for k in straight]
    worst = max(abs(tips_mm[k][0] - way) for k, way in zip(straight, fed))
    report.check("a straight wire reaches as far as it was fed (to three ticks of feed)", near(worst, 0.0, 0.12))
    weight_N_per_m, free_m = task.MASS_kg_per_m * 9.81, tips_mm[straight[-1]][0] * 1e-3
    sag_mm = weight_N_per_m * free_m**4 / (8 * task.BEND_STIFFNESS_N_m2) * 1e3
    report.check("and sags like a cantilever, w L^4 / (8 EI)", near(-tips_mm[straight[-1]][2], sag_mm, 0.002))
    away = [from_axis_m([v * 1e-3 for v in tip]) * 1e3 for tip in tips_mm]
    report.check("the tip stays in the vessel (4 mm less its radius, and 0.1 mm)", near(max(away), 0.0, 3.655))
    done = subprocess.run([OURS, "start_m=0"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    report.check("a task without its values is refused", equal(done.returncode, 2))


LINE = "simulated_s=3.6 processor_s=%s penetration_mm=%s length_error_pct=0 warnings=0 tips_mm=%s"
TIPS = ";".join(["1,2,3"] * task.SAMPLES)


def replaced(ours_s, peer_s, depth_mm="0.05", only="8 ms"):
    """Runs the script with programs that print the given figures; returns its exit code and its output."""
    with tempfile.TemporaryDirectory() as folder:
        os.makedirs(folder + "/peers/bin")
        own, theirs = LINE % (ours_s, "0.01", TIPS), LINE % (peer_s, depth_mm, TIPS)
        for path, line in (("ours", own), ("peers/bin/python", theirs)):
            tree_path = os.path.join(folder, path)
            with open(tree_path, "w", encoding="utf-8") as file:
                file.write("#!/bin/sh\necho '%s'\n" % line)
            os.chmod(tree_path, 0o755)
        command = [RUN_MOVING, "--ours", folder + "/ours", "--environment", folder + "/peers", "--rounds", "1"]
        command += ["--only", only, "--output", folder + "/table.tsv"]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        table = tree.read(folder + "/table.tsv") if os.path.exists(folder + "/table.tsv") else ""
        return done.returncode, done.stdout + table


def expect(report, name, got, code, *texts):
    findings = ["exit code %d, expected %d" % (got[0], code)] if got[0] != code else []
    report.check(name, findings + ["no '%s' in:\n%s" % (text, got[1]) for text in texts if text not in got[1]])


def script(report):
    expect(
        report,
        "a ratio above the bar passes, and is written",
        replaced("0.1", "2.0"),
        0,
        "ratio 20.0 (bar 15)",
        "env.over_peer\t20\t1\tpeer=cathsim task=moving",
        "env.over_peer\t20\t1\tpeer=chain task=moving",
    )
    expect(report, "a ratio below the bar fails", replaced("0.1", "1.0"), 1, "ratio 10.0, below the bar of 15")
    wrong = replaced("0.1", "2.0", "0.2")
    texts = ("1.8", "wrong: penetration_mm", "no setting that was tried")
    expect(report, "what fails is listed with its speed", wrong, 1, *texts)
    expect(report, "a line that is no number is named", replaced("fast", "1.0"), 1, "its line lacks a figure")
    expect(report, "changed physics has no bar", replaced("0.1", "0.2", only="damped"), 1, "changed physics: no bar")


def main():
    report = tree.Report()
    rules(report)
    geometry(report)
    our_run(report)
    script(report)
    report.end()


if __name__ == "__main__":
    main()
