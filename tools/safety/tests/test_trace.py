#!/usr/bin/env python3
"""Tests that every safety requirement has code, a test and a hazard, that docs/safety.md is up to date, and that each
kind of gap in the trace is found. Prints TAP."""

import os
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
sys.path.insert(0, os.path.join(ROOT, "tools", "safety"))
import tap  # noqa: E402
import trace_safety as trace  # noqa: E402

FILE = {
    "hazard": [{"id": "H-01", "severity": 2, "after": 1, "controls": ["SR-01"]}],
    "requirement": [{"id": "SR-01", "text": "a"}],
    "item": [{"name": "all", "folders": ["firmware"]}],
}
WHOLE = [("SR-01", "firmware/a.c", "f"), ("SR-01", "firmware/tests/test_a.c", "t")]


def gaps(found, file=None, folders=("firmware/core",)):
    return list(trace.faults_of(file or FILE, trace.trace_of(found), folders))


def the_trace_is_whole_and_the_page_up_to_date():
    done = subprocess.run(
        [sys.executable, "tools/safety/trace_safety.py"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        print("# " + (done.stdout + done.stderr).replace("\n", "\n# "))
    return done.returncode == 0


def a_requirement_without_code_or_test_is_a_gap():
    return gaps(WHOLE) == [] and len(gaps(WHOLE[:1])) == 1 and len(gaps(WHOLE[1:])) == 1 and len(gaps([])) == 2


def a_tag_and_a_hazard_without_a_requirement_are_gaps():
    wrong = dict(FILE, hazard=[dict(FILE["hazard"][0], controls=["SR-01", "SR-07"])])
    return len(gaps([*WHOLE, ("SR-99", "firmware/b.c", "g")])) == 1 and len(gaps(WHOLE, wrong)) == 1


def a_large_risk_needs_a_reason_and_a_folder_an_item():
    risky = dict(FILE, hazard=[dict(FILE["hazard"][0], after=5)])
    reasoned = dict(FILE, hazard=[dict(FILE["hazard"][0], after=5, residual="why")])
    return len(gaps(WHOLE, risky)) == 1 and gaps(WHOLE, reasoned) == [] and len(gaps(WHOLE, folders=("host/x",))) == 1


def a_tag_belongs_to_the_function_below_it():
    text = "/* Requirement: SR-01 */\n__attribute__((used)) static void crashed(const uint32_t *frame)\n"
    match = trace.TAG.search(text)
    return match is not None and trace.name_below(text, match.end()) == "crashed"


if __name__ == "__main__":
    tap.run(
        [
            the_trace_is_whole_and_the_page_up_to_date,
            a_requirement_without_code_or_test_is_a_gap,
            a_tag_and_a_hazard_without_a_requirement_are_gaps,
            a_large_risk_needs_a_reason_and_a_folder_an_item,
            a_tag_belongs_to_the_function_below_it,
        ]
    )
