#!/usr/bin/env python3
"""Compares our transmission pictures with those of gVirtualXray for equal meshes, geometry, materials and five
energies.

  run_xray_peers.py --ours build/bench/peer_xray --bodies out/aorta.bodies [--environment build/xray_peers] [--size 512]
                    [--rounds 5] [--output out/bench_xray_peers.tsv]

Prints the mean relative difference over those pixels inside the patient whose transmission is above 1e-4. Also prints
gVirtualXray's time per picture divided by our time. Our time is that of the whole picture, with scatter, noise and
display. The program prints one ratio for the elapsed time and one ratio for the processor time of all threads. The
requirement applies to the ratio of processor times, because other work on the machine does not change this ratio. The
program gVirtualXray is installed into a separate virtual environment (tools/lab/peers/xray_peers.txt). The exit code is
1 when a requirement is missed or when the measurement fails.
"""

import argparse
import array
import os
import sys
import tempfile

import run_peers
from run_peers import CannotMeasure

FOLDER = os.path.dirname(os.path.abspath(__file__))
DIFFERENCE_MAX_PCT, RATIO_MIN, TRANSMISSION_MIN, INSIDE_MAX = 1.0, 10.0, 1e-4, 0.999
NUMBERS = ("ms_min", "ms_median", "processor_ms_median")


def prepare(environment):
    """Returns the path of a virtual environment's Python that has gVirtualXray, and installs gVirtualXray if it is
    missing."""
    return run_peers.fetch(
        environment,
        "numpy, gvxrPython3",
        "gVirtualXray into %s (about 150 MB)" % environment,
        "xray_peers.txt",
        "gVirtualXray cannot be installed into %s: it takes a network, Python's venv module and the libraries of "
        "section [xraypeers] in tools/packages.txt. Nothing else of the project needs it." % environment,
    )


def measure(command):
    """Finds the last line of key=value pairs that the command printed, and returns these pairs, with times as
    numbers."""
    lines = [line for line in run_peers.run(command).splitlines() if line.startswith("code=")]
    pairs = dict(word.partition("=")[::2] for word in lines[-1].split()) if lines else {}
    for key in NUMBERS:
        try:
            pairs[key] = float(pairs[key])
        except (KeyError, ValueError) as error:
            raise CannotMeasure(
                "%s: no figure %s in '%s'" % (" ".join(command), key, lines[-1] if lines else "")
            ) from error
        if pairs[key] <= 0:
            raise CannotMeasure("%s: %s=%g" % (" ".join(command), key, pairs[key]))
    return pairs


def read_picture(path, pixels):
    picture = array.array("f")
    try:
        with open(path, "rb") as file:
            picture.frombytes(file.read())
    except (OSError, ValueError) as error:
        raise CannotMeasure("%s: %s" % (path, error)) from error
    if len(picture) != pixels:
        raise CannotMeasure("%s: %d pixels, expected %d" % (path, len(picture), pixels))
    if sys.byteorder != "little":
        picture.byteswap()
    return picture


def difference_pct(ours, theirs):
    """Returns the mean of |theirs/ours - 1| over the pixels inside the patient, and the number of these pixels."""
    total, count = 0.0, 0
    for own, other in zip(ours, theirs):
        if TRANSMISSION_MIN < own < INSIDE_MAX:
            total += abs(other / own - 1.0)
            count += 1
    if count == 0:
        raise CannotMeasure("no pixel lies inside the patient")
    return 100.0 * total / count, count


def compare(folder, views, size):
    rows = []
    for view in range(views):
        pictures = [
            read_picture(os.path.join(folder, "%s_%d.f32" % (code, view)), size * size) for code in ("ours", "gvxr")
        ]
        rows.append((view,) + difference_pct(*pictures))
    return rows


def report(rows, ours, theirs, size, output):
    total = sum(pct * count for _, pct, count in rows) / sum(count for _, _, count in rows)
    lines = ["view %d: mean relative difference of transmission %.3f %% over %d pixels" % row for row in rows]
    ratios = {key: theirs[key] / ours[key] for key in NUMBERS}
    lines.append("all views: %.3f %% (bar %g %%)" % (total, DIFFERENCE_MAX_PCT))
    lines.append(
        "gvxr %s / cournand, %d^2: %.1f by processor time (bar %g), %.1f by medians of the clock, %.1f by minima"
        % (
            theirs.get("version", "?"),
            size,
            ratios["processor_ms_median"],
            RATIO_MIN,
            ratios["ms_median"],
            ratios["ms_min"],
        )
    )
    os.makedirs(os.path.dirname(output) or ".", exist_ok=True)
    with open(output, "w", encoding="utf-8") as file:
        file.write("code\tsize\t%s\tdifference_pct\n" % "\t".join(NUMBERS))
        for code, row in (("cournand", ours), ("gvxr", theirs)):
            file.write("%s\t%d\t%s\t%.4f\n" % (code, size, "\t".join("%.4f" % row[key] for key in NUMBERS), total))
    print("\n".join(lines + ["written to %s" % output]))
    findings = ["view %d differs by %.2f %%" % (view, pct) for view, pct, _ in rows if pct > DIFFERENCE_MAX_PCT]
    if ratios["processor_ms_median"] < RATIO_MIN:
        findings.append("%.1f times faster, the bar is %g" % (ratios["processor_ms_median"], RATIO_MIN))
    for finding in findings:
        print("run_xray_peers: %s" % finding, file=sys.stderr)
    return 1 if findings else 0


def main():
    parser = argparse.ArgumentParser(description="Compare our transmission pictures with gVirtualXray's.")
    parser.add_argument("--ours", required=True, help="our program: build/bench/peer_xray")
    parser.add_argument("--bodies", required=True, help="the patient: out/aorta.bodies")
    parser.add_argument(
        "--environment", default=os.path.join("build", "xray_peers"), help="virtual environment of the peer"
    )
    parser.add_argument("--size", type=int, default=512, help="pixels along each edge, a multiple of 16 (default 512)")
    parser.add_argument("--rounds", type=int, default=5, help="pictures of each view that are timed (default 5)")
    parser.add_argument(
        "--output", default=os.path.join("out", "bench_xray_peers.tsv"), help="table (default out/bench_xray_peers.tsv)"
    )
    options = parser.parse_args()
    if options.rounds < 1 or not 64 <= options.size <= 2048 or options.size % 16:
        parser.error("--rounds is at least 1, --size a multiple of 16 from 64 to 2048")

    def work():
        python = prepare(options.environment)
        with tempfile.TemporaryDirectory() as folder:
            ours = measure([options.ours, options.bodies, folder, str(options.size), str(options.rounds)])
            theirs = measure([python, os.path.join(FOLDER, "peer_gvxr.py"), folder, str(options.rounds)])
            rows = compare(folder, int(ours.get("views", 0)), options.size)
        return report(rows, ours, theirs, options.size, options.output)

    return run_peers.status_of("run_xray_peers", work)


if __name__ == "__main__":
    sys.exit(main())
