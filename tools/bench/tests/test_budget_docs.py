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


def a_second_port_would_add_two_claims_of_jerked_tools():
    """docs/porting.md says so: of the eight claims that the RT1062 misses, the RT1176 keeps two, one above 90 %; both
    are found ticks, and none is a session."""
    missed, gained = [], []
    for key, values in budget_docs.chip_cases(budget.read_budget()):
        if key[0].startswith(("session=", "found")) and values["rt1062"] > budget_docs.FITS_permille:
            missed.append(key)
            gained += [(key[0], values["rt1176"])] if values["rt1176"] <= 1000 else []
            if values["stm32h735"] <= 1000:
                return False
    shares = sorted(share for _, share in gained)
    are_found = all(name.startswith("found") for name, _ in gained)
    return len(missed) == 8 and len(gained) == 2 and are_found and shares[0] <= budget_docs.FITS_permille < shares[1]


TESTS = (
    the_pages_say_what_the_budget_says,
    another_budget_gives_other_pages,
    a_second_port_would_add_two_claims_of_jerked_tools,
)
tap.run(TESTS)
