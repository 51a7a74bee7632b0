#!/usr/bin/env python3
"""Tests the column "now" of docs/bench.md, which budget_docs.py writes. Prints TAP."""

import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
TOOL = os.path.join(ROOT, "tools", "bench", "budget_docs.py")
sys.path.insert(0, os.path.dirname(TOOL))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import budget  # noqa: E402
import budget_docs  # noqa: E402
import tap  # noqa: E402


def the_page_says_what_the_budget_says():
    return subprocess.run([TOOL], cwd=ROOT, check=False).returncode == 0


def another_budget_gives_another_page():
    rows = budget.read_budget()
    with open(budget_docs.PAGE, encoding="utf-8") as file:
        text = file.read()
    return budget_docs.renewed(text, {key: value + 5000 for key, value in rows.items()}) != text


TESTS = (the_page_says_what_the_budget_says, another_budget_gives_another_page)
tap.run(TESTS)
