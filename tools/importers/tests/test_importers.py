#!/usr/bin/env python3
"""Runs a part of the test `make importers` with programs that are built without sanitizers; the readers get the
hand-made files and some hundred mutations of valid files. Prints TAP."""

import os
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "tools", "importers"))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import importers
import tree

FILES, SEEDS = 800, (7, 3)


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as folder:
        program = os.path.join(ROOT, os.environ.get("BUILD", "build"), "bin", "importers")
        counts = [importers.run(program, FILES, seed, folder).count for seed in SEEDS]
    count = {row: sum(one[row] for one in counts) for row in counts[0]}
    files = FILES * len(SEEDS)
    report.check(
        "%d malformed files are given to the readers" % files,
        [] if count["files"] >= files else ["only %d" % count["files"]],
    )
    for row, claim in (
        ("crashes", "no file ends a program"),
        ("over_20s", "no file takes over 20 s"),
        ("over_2GB", "no file takes over 2 GB"),
        ("silently_wrong", "no file is taken for another one"),
    ):
        report.check(claim, ["%d files: make importers keeps them in out/importers" % count[row]] if count[row] else [])
    report.end()


if __name__ == "__main__":
    main()
