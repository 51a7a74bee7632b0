#!/usr/bin/env python3
"""Times one rod in our core and in other simulators, and prints the ratios of the times (docs/bench.md, "Peers").

  run_peers.py --ours build/bench/peer_rod [--environment build/peers] [--repeats 5] [--output out/bench_peers.tsv]

Every simulator runs as a child process on the same processor core, and prints one line of key=value pairs. The
simulators run in turn, so that a slow minute of the machine affects all of them. For our core and MuJoCo, the time per
step of 1 ms is measured with the rod at rest; for PyElastica, it is the time per simulated millisecond. The other
simulators are installed into a separate virtual environment (tools/lab/peers/peers.txt). The exit code is 1 when a
simulator cannot be measured, when another simulator is more accurate than our core, or when our speed misses a
requirement.
"""

import argparse
import math
import os
import statistics
import subprocess
import sys

FOLDER = os.path.dirname(os.path.abspath(__file__))
TIME_LIMIT_S = 600
NUMBERS = (
    "step_us",
    "us_per_ms_min",
    "us_per_ms_median",
    "contacts",
    "length_error_pct",
    "tip_x_mm",
    "tip_z_mm",
    "elements",
    "bend_N_m2",
    "mass_g_per_m",
    "friction",
    "drag_per_s",
)
# The rod hangs for 3 s, or lies in the tube for 1.5 s, before its steps are timed.
SETTLE = {"free": 3000, "tube": 1500}
TIMED_TICKS, WARM_STEPS, TIMED_STEPS = 500, 1000, 2000
# (scene of the peer, peer, scene of ours, bar)
COMPARISONS = (
    ("tube", "mujoco", "tube", 10.0),
    ("free", "mujoco", "free", None),
    ("free", "pyelastica", "free", 1000.0),
)
LENGTH_mm, GRAVITY_m_s2 = 500.0, 9.81


class CannotMeasure(Exception):
    """Raised for an error; the message gives the cause, the location and the remedy."""


def tail(text, lines=4):
    return "\n".join(text.strip().splitlines()[-lines:])


def run(command):
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            timeout=TIME_LIMIT_S,
            check=False,
        )
    except FileNotFoundError as error:
        raise CannotMeasure("%s is missing: run `make bench-peers`" % command[0]) from error
    except subprocess.TimeoutExpired as error:
        raise CannotMeasure("%s: still running after %d s" % (" ".join(command), TIME_LIMIT_S)) from error
    if done.returncode != 0:
        raise CannotMeasure(
            "%s: exit code %d: %s" % (" ".join(command), done.returncode, tail(done.stderr or done.stdout))
        )
    return done.stdout


def fetch(environment, imports, announcement, packages, refusal):
    """Returns the path of a Python in a virtual environment that can import the modules `imports`; makes this
    environment from the list `packages` if it does not exist. `refusal` explains what this requires."""
    python = os.path.join(environment, "bin", "python")
    probe = [python, "-c", "import " + imports]
    if (
        os.path.exists(python)
        and subprocess.run(probe, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode == 0
    ):
        return python
    print("Fetching %s" % announcement, flush=True)
    try:
        run([sys.executable, "-m", "venv", environment])
        run(
            [
                python,
                "-m",
                "pip",
                "install",
                "--quiet",
                "--disable-pip-version-check",
                "-r",
                os.path.join(FOLDER, packages),
            ]
        )
        run(probe)
    except CannotMeasure as problem:
        raise CannotMeasure("%s\n%s" % (refusal, problem)) from problem
    return python


def prepare(environment):
    """Returns the path of a virtual environment's Python that has the other simulators, and installs them if they are
    missing."""
    return fetch(
        environment,
        "mujoco, elastica",
        "MuJoCo and PyElastica into %s (about 500 MB)" % environment,
        "peers.txt",
        "the other simulators cannot be installed into %s: it takes a network and Python's venv module (Debian: "
        "python3-venv). Nothing else of the project needs them." % environment,
    )


def parse(line, source):
    """Converts one line of key=value pairs to a dictionary, with numbers as float; raises an error if a value is
    missing or not a number."""
    pairs = dict(word.partition("=")[::2] for word in line.split())
    for key in ("code", "version", "scene") + NUMBERS:
        if not pairs.get(key):
            raise CannotMeasure("%s: its line has no %s: '%s'" % (source, key, line.strip()))
    for key in NUMBERS:
        try:
            pairs[key] = float(pairs[key])
        except ValueError as error:
            raise CannotMeasure("%s: %s=%s is no number" % (source, key, pairs[key])) from error
    if not pairs["us_per_ms_median"] >= pairs["us_per_ms_min"] > 0:
        raise CannotMeasure("%s: times of %g and %g us" % (source, pairs["us_per_ms_min"], pairs["us_per_ms_median"]))
    return pairs


def measure(command):
    lines = run(command).splitlines()
    return parse(lines[-1] if lines else "", " ".join(command))


def commands(ours, python):
    """Returns one command per simulator and scene, in the order in which a round of measurements runs them."""
    mujoco, elastica = os.path.join(FOLDER, "peer_mujoco.py"), os.path.join(FOLDER, "peer_elastica.py")
    for scene, settle in SETTLE.items():
        yield [ours, scene, str(settle), str(TIMED_TICKS)]
        yield [python, mujoco, scene, str(settle), str(TIMED_TICKS)]
    yield [python, elastica, "free", str(WARM_STEPS), str(TIMED_STEPS)]


def merge(rounds):
    """Returns one row per simulator and scene, with the smallest of the minimal times and the median of the median
    times."""
    rows = {}
    for row in rounds:
        rows.setdefault((row["code"], row["scene"]), []).append(row)
    for same in rows.values():
        same[0]["us_per_ms_min"] = min(row["us_per_ms_min"] for row in same)
        same[0]["us_per_ms_median"] = statistics.median(row["us_per_ms_median"] for row in same)
    return {key: same[0] for key, same in rows.items()}


def hanging_tip_mm(bend_N_m2, mass_g_per_m):
    """Returns the tip's position of an inextensible elastica (elastic rod) under its own weight w per length, by a
    shooting method for EI k' = w (L - s) cos(angle), where k is the curvature at the arc length s and L the length."""
    length, weight = LENGTH_mm * 1e-3, mass_g_per_m * 1e-3 * GRAVITY_m_s2

    def shoot(curvature, steps=1000):
        h = length / steps
        angle = x = z = 0.0
        for i in range(steps):  # midpoint rule
            half_angle = angle + h / 2 * curvature
            half = curvature - h / 2 * weight * (length - i * h) * math.cos(angle) / bend_N_m2
            x, z = x + h * math.cos(half_angle), z - h * math.sin(half_angle)
            curvature -= h * weight * (length - (i + 0.5) * h) * math.cos(half_angle) / bend_N_m2
            angle += h * half
        return curvature, x * 1e3, z * 1e3

    low, high = 0.0, weight * length**2 / bend_N_m2
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (low, middle) if shoot(middle)[0] > 0 else (middle, high)
    return shoot(high)[1:]


def add_tip_error(row):
    """Adds to the row the distance of the hanging tip from the closed form, in % of the rod's length. The distance of
    the hanging tip from the closed form is NaN if no rod hangs at rest."""
    row["tip_error_pct"] = math.nan
    if row["scene"] == "free":
        x, z = hanging_tip_mm(row["bend_N_m2"], row["mass_g_per_m"])
        row["tip_error_pct"] = math.hypot(row["tip_x_mm"] - x, row["tip_z_mm"] - z) / LENGTH_mm * 100


def same_physics(rows):
    """Yields a message for each physical value that differs between the simulators but should be equal."""
    for key in ("elements", "bend_N_m2", "mass_g_per_m", "friction", "drag_per_s"):
        values = {row[key] for row in rows.values() if not math.isnan(row[key])}
        if max(values) - min(values) > 1e-3 * max(values):
            yield "%s is not the same for all codes: %s" % (key, ", ".join("%g" % v for v in sorted(values)))


def compare(rows):
    """Returns, for each comparison, the text of the ratio, and an error message or None."""
    for scene, peer, our_scene, bar in COMPARISONS:
        theirs, ours = rows[(peer, scene)], rows[("cournand", our_scene)]
        ratio = theirs["us_per_ms_median"] / ours["us_per_ms_median"]
        fastest = theirs["us_per_ms_min"] / ours["us_per_ms_min"]
        text = "%s / cournand, %s: %.1f by medians, %.1f by minima" % (peer, scene, ratio, fastest)
        finding = None
        if bar is not None:
            text += " (bar %g)" % bar
            if min(ratio, fastest) < bar:
                finding = "%s: below the bar of %g" % (text, bar)
        for key in ("length_error_pct", "tip_error_pct"):
            if abs(theirs[key]) + 0.005 < abs(ours[key]):
                finding = "%s, %s: %s is %.4f, ours %.4f: not at equal accuracy" % (
                    peer,
                    scene,
                    key,
                    theirs[key],
                    ours[key],
                )
        yield text, finding


def write_table(rows, path):
    columns = ["code", "version", "scene"] + list(NUMBERS) + ["tip_error_pct"]
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\t".join(columns) + "\n")
        for row in rows.values():
            file.write("\t".join("%.6g" % row[c] if isinstance(row[c], float) else row[c] for c in columns) + "\n")


def percent(value):
    return "-" if math.isnan(value) else "%.4f %%" % abs(value)


def print_table(rows):
    print(
        "%-11s %-8s %-5s %8s %13s %13s %9s %10s %9s"
        % ("code", "version", "scene", "step us", "us/ms minimum", "us/ms median", "contacts", "length err", "tip err")
    )
    for row in rows.values():
        print(
            "%-11s %-8s %-5s %8g %13.1f %13.1f %9d %10s %9s"
            % (
                row["code"],
                row["version"],
                row["scene"],
                row["step_us"],
                row["us_per_ms_min"],
                row["us_per_ms_median"],
                row["contacts"],
                percent(row["length_error_pct"]),
                percent(row["tip_error_pct"]),
            )
        )


def run_rounds(ours, python, repeats):
    rounds = []
    for repeat in range(repeats):
        for command in commands(ours, python):
            rounds.append(measure(command))
        print("round %d of %d" % (repeat + 1, repeats), file=sys.stderr, flush=True)
    return merge(rounds)


def report(rows, path):
    for row in rows.values():
        add_tip_error(row)
    write_table(rows, path)
    print_table(rows)
    findings = list(same_physics(rows))
    for text, finding in compare(rows):
        print(text)
        findings += [finding] if finding else []
    print("written to %s" % path)
    for finding in findings:
        print("run_peers: %s" % finding, file=sys.stderr)
    return 1 if findings else 0


def status_of(name, work):
    """Returns the exit code of work(), or prints a message and returns 1 when the measurement fails or is stopped."""
    try:
        return work()
    except CannotMeasure as problem:
        print("%s: %s" % (name, problem), file=sys.stderr)
    except KeyboardInterrupt:
        print("%s: stopped" % name, file=sys.stderr)
    return 1


def main():
    parser = argparse.ArgumentParser(description="Time one rod in our core and in other simulators.")
    parser.add_argument("--ours", required=True, help="our program: build/bench/peer_rod")
    parser.add_argument(
        "--environment", default=os.path.join("build", "peers"), help="virtual environment of the peers"
    )
    parser.add_argument("--repeats", type=int, default=5, help="rounds (default 5)")
    parser.add_argument(
        "--output", default=os.path.join("out", "bench_peers.tsv"), help="table (default out/bench_peers.tsv)"
    )
    options = parser.parse_args()
    if options.repeats < 1:
        parser.error("--repeats is at least 1")

    def work():
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        return report(run_rounds(options.ours, prepare(options.environment), options.repeats), options.output)

    return status_of("run_peers", work)


if __name__ == "__main__":
    sys.exit(main())
