#!/usr/bin/env python3
"""Tests that the program `chip` prices a case of the budget as firmware/bench/budget.tsv says, and refuses a damaged
case by its name; that every searched scene has a found tick. Prints TAP."""

import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "tools", "bench"))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import budget  # noqa: E402
import chip_budget  # noqa: E402
import tap  # noqa: E402

BUILD = os.environ.get("BUILD", "build")
CASE, CONTEXT = "3", "elements=128 contacts=20+"


def with_case(use):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "case")
        program = os.path.join(BUILD, "bench", "budget_make")
        subprocess.run([program, "make", CASE, path], cwd=ROOT, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        return use(path)


def a_case_is_priced_as_the_budget_says():
    """A figure may lie up to 3 % above its row, as in `make budget`, and as far below it."""
    rows = budget.read_budget()
    instructions = rows["rod.m7_instructions", CONTEXT]
    priced = with_case(lambda path: chip_budget.case_rows(BUILD, path, CONTEXT, chip_budget.MEAN, instructions))
    wrong = [row for row in priced if not 0.97 <= row[1] / rows[row[0], row[3]] <= budget.OVER]
    for row in wrong:
        print("# %s %s: %d, the budget has %d" % (row[0], row[3], row[1], rows[row[0], row[3]]))
    return len(priced) > 5 and not wrong


def a_damaged_case_is_refused():
    def use(path):
        with open(path, "r+b") as file:
            file.truncate(100)
        try:
            chip_budget.case_rows(BUILD, path, CONTEXT, chip_budget.MEAN, 1)
        except chip_budget.CannotPrice as problem:
            return path in str(problem) and "is no case" in str(problem)
        return False

    return with_case(use)


def every_searched_scene_has_a_found_tick_and_a_row():
    found = {(scene, tools) for scene, tools, _, _ in chip_budget.found_ticks()}
    rows = budget.read_budget()
    contexts = ["found scene=%s tools=%s" % (scene, ",".join(tools)) for scene, tools in chip_budget.SEARCHED]
    return found == set(chip_budget.SEARCHED) and all(("chip.cycles", context) in rows for context in contexts)


TESTS = (
    a_case_is_priced_as_the_budget_says,
    a_damaged_case_is_refused,
    every_searched_scene_has_a_found_tick_and_a_row,
)
tap.run(TESTS)
