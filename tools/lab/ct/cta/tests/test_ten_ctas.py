#!/usr/bin/env python3
"""Ten generated persons: virtual CT angiograms become scenes without a click. Prints a row per person, as in
docs/own_ct.md, and TAP.
"""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import virtual_cta  # noqa: E402

SEEDS = range(1, 11)
OPTIONS = ("--pixel-mm", "0.9", "--slice-mm", "1.25")
WIDE_FOUND_MEAN, MADE = 0.8, 9


def main():
    report, rows, findings = virtual_cta.tree.Report(), [], []
    for seed in SEEDS:
        try:
            rows.append(virtual_cta.row_of(seed, os.path.join(virtual_cta.BUILD, "virtual_cta", str(seed)), OPTIONS))
            print("# " + virtual_cta.text_of(rows[-1]), flush=True)
        except RuntimeError as error:
            findings.append(str(error))
    for finding in findings:
        print("# " + finding.replace("\n", " "))
    report.check("at least %d persons become scenes" % MADE, findings if len(rows) < MADE else [])
    mean = sum(row["wide"][0] for row in rows) / max(1, len(rows))
    report.check("wide vessels are found", ["only %.0f %%" % (100 * mean)] if mean < WIDE_FOUND_MEAN else [])
    report.end()


if __name__ == "__main__":
    main()
