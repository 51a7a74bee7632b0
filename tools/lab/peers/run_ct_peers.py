#!/usr/bin/env python3
"""Compares our transmission pictures of a CT with those of DiffDRR on the processor, for equal voxels and geometry.

  run_ct_peers.py --ours build/bench/peer_ct [--environment build/ct_peers] [--edge 512] [--size 512] [--rounds 3]
                  [--output out/bench_ct_peers.tsv]

Prints the mean relative difference over those pixels inside the patient whose transmission is above 1e-4, and DiffDRR's
time per picture divided by our time. Our time is that of the whole picture, with scatter, noise and display; DiffDRR's
is that of the line integrals alone. The requirement applies to the ratio of processor times, because other work on the
machine does not change this ratio. DiffDRR is installed into a virtual environment of its own, which sees Debian's
PyTorch (section [ctpeers] of tools/packages.txt). The exit code is 1 when a requirement is missed or when the
measurement fails.
"""

import argparse
import os
import sys
import tempfile

import run_peers
import run_xray_peers
from run_peers import CannotMeasure
from run_xray_peers import DIFFERENCE_MAX_PCT, NUMBERS, RATIO_MIN

FOLDER = os.path.dirname(os.path.abspath(__file__))
DEBIAN_PYTHON = "/usr/bin/python3"  # the one that has Debian's PyTorch


def prepare(environment):
    """Returns the path of a virtual environment's Python that has DiffDRR, and installs DiffDRR if it is missing."""
    python = os.path.join(environment, "bin", "python")
    probe = [python, "-c", "import torch, diffdrr.renderers"]
    try:
        run_peers.run(probe)
        return python
    except (CannotMeasure, OSError):
        print("Fetching DiffDRR into %s (35 MB)" % environment, flush=True)
    try:
        run_peers.run([DEBIAN_PYTHON, "-m", "venv", "--system-site-packages", environment])
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
        run_peers.run(pip + ["-r", os.path.join(FOLDER, "ct_peers.txt")])
        run_peers.run(probe)
    except CannotMeasure as problem:
        raise CannotMeasure(
            "DiffDRR cannot be installed into %s: it takes a network and the packages of section [ctpeers] in "
            "tools/packages.txt. Nothing else of the project needs it.\n%s" % (environment, problem)
        ) from problem
    return python


def compare(folder, views, size):
    rows = []
    for view in range(views):
        pictures = [
            run_xray_peers.read_picture(os.path.join(folder, "%s_%d.f32" % (code, view)), size * size)
            for code in ("ours", "diffdrr")
        ]
        rows.append((view,) + run_xray_peers.difference_pct(*pictures))
    return rows


def report(rows, ours, theirs, options):
    total = sum(pct * count for _, pct, count in rows) / sum(count for _, _, count in rows)
    ratio = theirs["processor_ms_median"] / ours["processor_ms_median"]
    lines = ["view %d: mean relative difference of transmission %.3f %% over %d pixels" % row for row in rows]
    lines.append("all views: %.3f %% (bar %g %%)" % (total, DIFFERENCE_MAX_PCT))
    lines.append(
        "diffdrr %s / cournand, %d^2 through %d^3 voxels: %.1f by processor time (bar %g), %.1f by medians of the clock"
        % (
            theirs.get("version", "?"),
            options.size,
            options.edge,
            ratio,
            RATIO_MIN,
            theirs["ms_median"] / ours["ms_median"],
        )
    )
    os.makedirs(os.path.dirname(options.output) or ".", exist_ok=True)
    with open(options.output, "w", encoding="utf-8") as file:
        file.write("code\tsize\tedge\t%s\tdifference_pct\n" % "\t".join(NUMBERS))
        for code, row in (("cournand", ours), ("diffdrr", theirs)):
            figures = "\t".join("%.4f" % row[key] for key in NUMBERS)
            file.write("%s\t%d\t%d\t%s\t%.4f\n" % (code, options.size, options.edge, figures, total))
    print("\n".join(lines + ["written to %s" % options.output]))
    findings = ["view %d differs by %.2f %%" % (view, pct) for view, pct, _ in rows if not pct <= DIFFERENCE_MAX_PCT]
    if not ratio >= RATIO_MIN:
        findings.append("%.1f times faster, the bar is %g" % (ratio, RATIO_MIN))
    for finding in findings:
        print("run_ct_peers: %s" % finding, file=sys.stderr)
    return 1 if findings else 0


def main():
    parser = argparse.ArgumentParser(description="Compare our transmission pictures of a CT with DiffDRR's.")
    parser.add_argument("--ours", required=True, help="our program: build/bench/peer_ct")
    parser.add_argument("--environment", default=os.path.join("build", "ct_peers"), help="virtual environment")
    parser.add_argument("--edge", type=int, default=512, help="voxels along each edge (default 512)")
    parser.add_argument("--size", type=int, default=512, help="pixels along each edge, a multiple of 16 (default 512)")
    parser.add_argument("--rounds", type=int, default=3, help="pictures of each view that are timed (default 3)")
    parser.add_argument("--output", default=os.path.join("out", "bench_ct_peers.tsv"), help="table that is written")
    options = parser.parse_args()
    if options.rounds < 1 or not 64 <= options.size <= 2048 or options.size % 16 or not 32 <= options.edge <= 640:
        parser.error("--rounds is at least 1, --size a multiple of 16 from 64 to 2048, --edge 32 to 640")

    def work():
        python = prepare(options.environment)
        with tempfile.TemporaryDirectory() as folder:
            sizes = [str(options.edge), str(options.size), str(options.rounds)]
            ours = run_xray_peers.measure([options.ours, folder] + sizes)
            theirs = run_xray_peers.measure([python, os.path.join(FOLDER, "peer_diffdrr.py"), folder, "1"])
            rows = compare(folder, int(ours.get("views", 0)), options.size)
        return report(rows, ours, theirs, options)

    return run_peers.status_of("run_ct_peers", work)


if __name__ == "__main__":
    sys.exit(main())
