#!/usr/bin/env python3
"""Measures the performance of the program's window on two processors of this machine, without a graphics card, under a
virtual display. Keys are real events. The script writes the values suite.keys_to_case, suite.tick_late_pct,
suite.pictures_per_s and suite.hand_to_picture_ms of docs/bench.md. With --pci the script also writes suite.pci_actions
(pci_by_hand.py)."""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time

import pci_by_hand
from bench_window import Keyboard, focus, shows, window_of

WIRE = "shared/examples/instruments/j_wire.toml"


def figures_at_end(window, folder):
    """Ends the window's program, and returns the figures that it writes at its end."""
    window.send_signal(signal.SIGINT)
    window.wait(timeout=120)
    with open(os.path.join(folder, "timing.json"), encoding="utf-8") as file:
        return json.load(file)


def processors():
    """Returns two of the processors that this process may use."""
    return sorted(os.sched_getaffinity(0))[:2]


def press(seconds, environment):
    """Gives the window the keyboard focus, and taps the arrow keys like a person who steers a tool. The keys are tapped
    at random times, so that they are not in step with the X-ray pulses. Returns the times at which each key went down
    and up."""
    end = time.monotonic() + seconds
    focus(environment, seconds)
    keyboard = Keyboard(environment["DISPLAY"])
    chance = random.Random(1)
    sent = []
    while time.monotonic() < end:
        key = chance.choice(["Up", "Right", "Down", "Left"])
        for is_down in (True, False):
            sent.append(keyboard.send(key, is_down))
            time.sleep(chance.uniform(0.1, 0.3))
    keyboard.close()
    return sent


def delays_ms(sent, figures):
    """Returns, for each press or release of a key, the time until the screen shows the first X-ray pulse after it."""
    times = figures["hand_to_picture"]["read_and_shown_s"]
    delays = []
    for begin in sent:
        shown = next((shown for read, shown in times if read >= begin), None)
        if shown is not None:
            delays.append((shown - begin) * 1e3)
    return sorted(delays)


def measure(options, size, pulses, taps):
    """Runs the window for as long as the option --seconds states. With `taps`, returns the delays from the keys to the
    pictures; otherwise returns the window's figures."""
    words = ["--scene", options.scene, "--tool", WIRE, "--size", str(size), "--fluoro", "--no-record"]
    with window_of(options, words, preexec_fn=lambda: os.sched_setaffinity(0, processors())) as run:
        window, environment, folder = run
        if pulses == 30:
            time.sleep(3)
            focus(environment)
            subprocess.run(["xdotool", "key", "f", "p", "f"], env=environment, check=False)
        if not taps:
            time.sleep(options.seconds)
            return figures_at_end(window, folder)
        time.sleep(3)
        sent = press(options.seconds, environment)
        time.sleep(0.5)
        return delays_ms(sent, figures_at_end(window, folder))


def keys_to_case(options):
    """Presses keys from the start screen until the first picture of a case appears; returns the number of keys."""
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
        delays = measure(options, 512, pulses, True)
        if not delays:
            sys.exit("suite.py: the window received no key; is another window in front of it?")
        for share in (50, 95):
            context = "size=512 pulses=%d share=p%d inputs=%d processors=2 %s" % (pulses, share, len(delays), load)
            delay = delays[min(len(delays) - 1, len(delays) * share // 100)]
            rows.append(("suite.hand_to_picture_ms", "%.1f" % delay, "ms", context))
    if options.pci:
        rows.append(pci_by_hand.measure(options))
    text = "".join("\t".join(row) + "\n" for row in rows)
    with open(options.output, "w", encoding="utf-8") as file:
        file.write(text)
    print(text, end="")


if __name__ == "__main__":
    main()
