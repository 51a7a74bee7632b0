#!/usr/bin/env python3
"""Tests that Frama-C EVA finds no other alarms in the safety code, the fixed-point code and the lumen than the
explained ones, that a new alarm and a vanished one are reported, and that the tests that an explanation names exist.
Prints TAP."""

import os
import subprocess
import sys
import tempfile
import tomllib

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
sys.path.insert(0, os.path.join(ROOT, "tools", "safety"))
import eva  # noqa: E402
import tap  # noqa: E402


def every_alarm_is_explained():
    done = subprocess.run(
        [sys.executable, "tools/safety/eva.py"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        print("# " + (done.stdout + done.stderr).replace("\n", "\n# "))
    return done.returncode == 0


def a_new_alarm_and_a_vanished_one_are_reported():
    known = eva.explained()
    key = next(iter(known))
    fewer = {k: v for k, v in known.items() if k != key}
    return (
        eva.differences(known, known, list(eva.DRIVERS)) == []
        and eva.differences(known, fewer, list(eva.DRIVERS))
        == ["new alarm (%s): %s" % (key[0], eva.text_of(known[key]))]
        and len(eva.differences(fewer, known, list(eva.DRIVERS))) == 1
    )


def a_silence_that_is_counted_without_a_limit_is_an_alarm():
    """Analyses the driver `timing` with a silence of the host that is counted without a limit."""
    good = "if (watchdog->silent_ticks >= CRN_APP_HOST_SILENT_ticks + CRN_APP_FADE_ticks) return;"
    bad = ""
    sources, options = eva.DRIVERS["timing"]
    with tempfile.TemporaryDirectory(dir=os.path.join(ROOT, "tools", "safety")) as folder:
        path = os.path.join(folder, "watchdog.c")
        with open(os.path.join(ROOT, "firmware/app/safety/watchdog.c"), encoding="ascii") as file:
            text = file.read()
        if good not in text:
            print("# firmware/app/safety/watchdog.c no longer has the line that this test changes")
            return False
        with open(path, "w", encoding="ascii") as file:
            file.write(text.replace(good, bad))
        changed = [os.path.relpath(path, ROOT) if s.endswith("watchdog.c") else s for s in sources]
        eva.DRIVERS["timing"] = (changed, options)
        try:
            properties, _ = eva.analyse("timing", folder)
        finally:
            eva.DRIVERS["timing"] = (sources, options)
        return len(eva.alarms_of("timing", properties)) > 0


def explanations_name_tests_that_exist():
    with open(os.path.join(ROOT, eva.ALARMS), "rb") as file:
        reasons = tomllib.load(file)["reason"]
    missing = []
    for shown in (shown for reason in reasons for shown in reason["shown_by"]):
        path, _, name = shown.partition(": ")
        with open(os.path.join(ROOT, path), encoding="ascii") as file:
            if "static void %s(" % name not in file.read():
                missing.append(shown)
    for shown in missing:
        print("# no such test: " + shown)
    return not missing and all(reason["shown_by"] for reason in reasons)


if __name__ == "__main__":
    tap.run(
        [
            every_alarm_is_explained,
            a_new_alarm_and_a_vanished_one_are_reported,
            a_silence_that_is_counted_without_a_limit_is_an_alarm,
            explanations_name_tests_that_exist,
        ]
    )
