#!/usr/bin/env python3
"""Tests that tools/safety/misra.py counts a known deviation, reports a risen count, a new rule and a rule without a
justification, and accepts what the table allows. Prints TAP."""

import os
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
sys.path.insert(0, os.path.join(ROOT, "tools", "safety"))
import misra  # noqa: E402
import tap  # noqa: E402

# Line 3 jumps (rule 15.1), line 4 is an octal number (7.1).
SAMPLE = "int sample(int a);\nint sample(int a) {\n    if (a > 1) { goto end; }\n    a = 017;\nend:\n    return a;\n}\n"


def a_known_deviation_is_found_at_its_line():
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "sample.c"), "w", encoding="ascii") as file:
            file.write(SAMPLE)
        found = misra.findings(["sample.c"], folder)
    return ("15.1", "sample.c", 3) in found and ("7.1", "sample.c", 4) in found


def lines_count_once_for_their_part():
    found = {("15.5", "firmware/core/a.c", 1), ("15.5", "firmware/app/b.c", 2), ("15.5", "firmware/core/a.c", 9)}
    return misra.counts_of(found) == {"15.5": [2, 1, 0]}


def a_risen_count_a_new_rule_and_a_missing_justification_are_faults():
    rows = {"15.5": ([2, 1, 0], "why"), "8.9": ([1, 0, 0], "")}
    return (
        misra.faults({"15.5": [2, 1, 0]}, rows) == []
        and misra.faults({"15.5": [1, 0, 0]}, rows) == []
        and len(misra.faults({"15.5": [3, 1, 0]}, rows)) == 1
        and len(misra.faults({"8.9": [1, 0, 0]}, rows)) == 1
        and len(misra.faults({"21.3": [1, 0, 0]}, rows)) == 2
    )


def every_row_of_the_table_has_a_justification_and_a_count():
    bad = [rule for rule, (counts, why) in misra.table().items() if len(why) < 20 or sum(counts) == 0]
    for rule in bad:
        print("# rule " + rule)
    return not bad


if __name__ == "__main__":
    tap.run(
        [
            a_known_deviation_is_found_at_its_line,
            lines_count_once_for_their_part,
            a_risen_count_a_new_rule_and_a_missing_justification_are_faults,
            every_row_of_the_table_has_a_justification_and_a_count,
        ]
    )
