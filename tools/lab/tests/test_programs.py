#!/usr/bin/env python3
"""Tests the programs in tools/lab: each program prints its version. If the output file cannot be written, each program
reports this error before it starts its work. Prints TAP."""

import os
import shutil
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path[:0] = [os.path.join(ROOT, "tools", "check"), os.path.join(ROOT, "tools", "check", "tests")]
import test_bad_input as bad  # noqa: E402
import test_versions  # noqa: E402

NAMES = ("calibrate", "ct", "importers", "literature", "reference_rod", "validate", "vcsim3")


def outputs(bench):
    bench.write("good.toml", bad.scene_text())
    bench.write("good.scene", bad.scene_file())
    bench.bad(
        "a validation into a folder below a file is refused first",
        ["validate", "-o", "good.toml/x"],
        1,
        "cannot be written",
    )
    case = [
        "reference_rod",
        "--instrument",
        bad.WIRE,
        "--scene",
        "good.scene",
        "--depth",
        "a:10:0",
        "-o",
        "good.toml/x",
    ]
    bench.bad("a case into a folder below a file is refused first", case, 1, "cannot be written")


def main():
    folder = tempfile.mkdtemp()
    try:
        bench = bad.Bench(folder)
        outputs(bench)
        test_versions.check_names(bench.report, NAMES)
        bench.report.end()
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
