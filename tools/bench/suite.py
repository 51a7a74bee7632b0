#!/usr/bin/env python3
"""Measures the window on two processors of this machine, without a graphics card, under a virtual display. Keys are
real events. The lines that it writes are suite.keys_to_case, suite.tick_late_pct, suite.pictures_per_s and
suite.hand_to_picture_ms of docs/bench.md, and suite.pci_actions with --pci (pci_by_hand.py)."""

import argparse
import json
import os
import signal
import subprocess
import sys
import time

import pci_by_hand
from bench_window import focus, shows, window_of

WIRE = "shared/examples/instruments/j_wire.toml"


def figures_at_end(window, folder):
    """Ends the window, and returns the figures that it writes."""
    window.send_signal(signal.SIGINT)
    window.wait(timeout=120)
    with open(os.path.join(folder, "timing.json"), encoding="utf-8") as file:
        return json.load(file)


def processors():
    """Returns two of the processors that this process may use."""
    return sorted(os.sched_getaffinity(0))[:2]


def press(seconds, environment):
    """Gives the window the keyboard, and taps a key every 0.4 s, as a hand that steers."""
    end = time.monotonic() + seconds
    focus(environment, seconds)
    keys = ["Up", "Right", "Down", "Left"]
    taps = 0
    while time.monotonic() < end:
        subprocess.run(["xdotool", "key", "--delay", "120", keys[taps % 4]], env=environment, check=False)
        taps += 1
        time.sleep(0.4)


def measure(options, size, pulses, taps):
    """Runs the window for a while; returns its figures."""
    words = ["--scene", options.scene, "--tool", WIRE, "--size", str(size), "--fluoro", "--no-record"]
    with window_of(options, words, preexec_fn=lambda: os.sched_setaffinity(0, processors())) as run:
        window, environment, folder = run
        if pulses == 30:
            time.sleep(3)
            press(1.5, environment)
            subprocess.run(["xdotool", "key", "f", "p", "f"], env=environment, check=False)
        if taps:
            press(options.seconds, environment)
        else:
            time.sleep(options.seconds)
        return figures_at_end(window, folder)


def keys_to_case(options):
    """Presses keys from the start screen until the first picture of a case; returns their number."""
    keys = 0
    with window_of(options, ["--start"], has_layout=True) as (window, environment, folder):
        for control, key in (("card 2", "2"), ("ready", "Return"), ("row 1", "space")):
            shows(os.path.join(folder, "layout"), control, window)
            if keys == 0:
                focus(environment)
                time.sleep(0.5)
            action = "keydown" if key == "space" else "key"
            subprocess.run(["xdotool", action, key], env=environment, check=False)
            keys += 1
        time.sleep(5)
        if figures_at_end(window, folder)["pictures"] == 0:
            sys.exit("suite.py: %d keys led to no picture" % keys)
    return keys


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", default="build")
    parser.add_argument("--scene", default="out/aorta.scene")
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--output", default="out/suite.tsv")
    parser.add_argument("--pci", action="store_true", help="also play a whole angioplasty by hand, 5 to 15 minutes")
    options = parser.parse_args()
    rows = [("suite.keys_to_case", str(keys_to_case(options)), "keys", "case=first_push")]
    quiet = measure(options, 512, 15, False)
    load = "load=%.1f" % os.getloadavg()[0]
    context = "size=512 pulses=15 processors=2 %s" % load
    rows.append(("suite.tick_late_pct", "%.3f" % quiet["tick_late_pct"], "%", context))
    large = measure(options, 1024, 30, False)
    rows.append(
        ("suite.pictures_per_s", "%.1f" % large["pictures_per_s"], "1/s", "size=1024 pulses=30 processors=2 " + load)
    )
    for pulses in (15, 30):
        steered = measure(options, 512, pulses, True)["hand_to_picture"]
        if steered["p95_ms"] is None:
            sys.exit("suite.py: the window received no key; is another window in front of it?")
        for share in ("p50", "p95"):
            rows.append(
                (
                    "suite.hand_to_picture_ms",
                    "%.1f" % steered[share + "_ms"],
                    "ms",
                    "size=512 pulses=%d share=%s inputs=%d processors=2 %s" % (pulses, share, steered["inputs"], load),
                )
            )
    if options.pci:
        rows.append(pci_by_hand.measure(options))
    text = "".join("\t".join(row) + "\n" for row in rows)
    with open(options.output, "w", encoding="utf-8") as file:
        file.write(text)
    print(text, end="")


if __name__ == "__main__":
    main()
