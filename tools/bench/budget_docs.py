#!/usr/bin/env python3
"""Copies the values of firmware/bench/budget.tsv into the column "now" of docs/bench.md, between the two marks on that
page.

  budget_docs.py [--write]

Without --write this program only compares the page with the budget, and its exit code is 1 when the two differ.
"""

import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools", "bench"))
import budget  # noqa: E402

PAGE = os.path.join(ROOT, "docs", "bench.md")
BEGIN, END = "<!-- begin: written by `make budget-docs` -->\n", "<!-- end -->\n"
MEAN, WORST = "rod.m7_instructions", "rod.m7_instructions_worst"
# case, row of the budget, first version with three tools, goal
ROWS = (
    ("100 contacts (122 in the case)", MEAN, "elements=256 contacts=100+", "1,298 k", "400 k"),
    ("all in contact", MEAN, "elements=256 contacts=all", "1,388 k", "470 k"),
    ("three tools sliding, all in contact", MEAN, "elements=256 contacts=all tools=3 sliding", "1,696 k", ""),
    ("128 elements", MEAN, "elements=128 contacts=20+", "497 k", "190 k"),
    ("worst tick that missed a contact", WORST, "elements=256 second_solve", "1,874 k", "800 k"),
)


def table(rows):
    lines = [
        "| Cortex-M7, 256 elements where not said otherwise | first version with three tools | now | goal |\n",
        "|---|---|---|---|\n",
    ]
    for case, name, context, first, goal in ROWS:
        lines.append("| %s | %s | {:,} k | %s |\n".format(round(rows[name, context] / 1000)) % (case, first, goal))
    return "".join(lines)


def renewed(text, rows):
    """Returns the text of the page after replacing the block between the two marks."""
    before, mark, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not mark or not end:
        raise SystemExit("budget_docs: docs/bench.md has no block between '%s' and '%s'" % (BEGIN.strip(), END.strip()))
    return before + BEGIN + table(rows) + END + after


def main():
    with open(PAGE, encoding="utf-8") as file:
        text = file.read()
    new = renewed(text, budget.read_budget())
    if sys.argv[1:] == ["--write"]:
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(new)
        return 0
    if new != text:
        print(
            "docs/bench.md is not what firmware/bench/budget.tsv says: `make budget-docs` writes it anew",
            file=sys.stderr,
        )
    return int(new != text)


if __name__ == "__main__":
    sys.exit(main())
