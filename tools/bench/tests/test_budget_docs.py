#!/usr/bin/env python3
"""Tests the tables that budget_docs.py writes into three pages. Prints TAP."""

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


def the_pages_say_what_the_budget_says():
    return subprocess.run([TOOL], cwd=ROOT, check=False).returncode == 0


def another_budget_gives_other_pages():
    rows = {key: value + 5000 for key, value in budget.read_budget().items()}
    for page, make in budget_docs.PAGES:
        with open(os.path.join(ROOT, "docs", page), encoding="utf-8") as file:
            text = file.read()
        if budget_docs.renewed(text, rows, page, make) == text:
            return False
    return True


TESTS = (the_pages_say_what_the_budget_says, another_budget_gives_other_pages)
tap.run(TESTS)
