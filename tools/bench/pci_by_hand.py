#!/usr/bin/env python3
"""Plays a whole angioplasty of the left anterior descending artery in the window, from the start screen to the score.
The script sends real keys and clicks under a virtual display, as a person would. An action is one click, or one key
that is pressed and released. A key may be held; the script releases it when the expected text appears on the screen.
The script reads only the file that the window writes for the option --layout; the file holds the texts that the window
shows for devices, goals and inflator. The script writes the value suite.pci_actions, which docs/bench.md explains."""

import argparse
import os
import re
import subprocess
import sys
import time

from bench_window import focus, window_of

ACTIONS_MAX = 60
TRIES_MAX = 8  # to lead the wire into the artery
TURN_DEG = 137.0  # between two tries: the golden angle, so that no direction is tried twice
WIRE, BALLOON, GUIDE = 1, 2, 3
DEVICES = ("Coronary wire 0.014 in", "Balloon 3.0 x 20", "Guide JL3 6F")
ACROSS_MM = 75  # of the artery that the wire's tip is beyond its origin: far behind the narrow place
ASTRAY_MM = 8  # in another vessel
STUCK_S = 6
LESION_MM = 37  # from the artery's origin to the middle of the narrow place, as the first cine run shows
BALLOON_MIDDLE_MM = 15  # from its tip
POST_MAX = 2  # inflations in the open stent
RESULT_GOALS = {"goal 2 reached", "goal 3 reached"}  # residual stenosis and struts at the wall
OFF_MM = 1.5  # that the balloon may be beside the narrow place
ON_THE_WAY = ("LAD", "LM", "ascending aorta", "aortic arch", "?")


class Failed(Exception):
    pass


class Screen:
    """Holds what the window shows, as the rows of the layout file."""

    def __init__(self, path, window):
        self.path, self.window = path, window

    def rows(self):
        try:
            with open(self.path, encoding="utf-8") as file:
                return {row[0]: row for row in (line.rstrip("\n").split("\t") for line in file)}
        except FileNotFoundError:
            return {}

    def text(self, name):
        row = self.rows().get(name, [])
        return row[5] if len(row) > 5 else ""

    def place(self, name):
        _, x, y, width, height = self.rows()[name][:5]
        return int(x) + int(width) // 2, int(y) + int(height) // 2

    def wait(self, name, seconds):
        end = time.monotonic() + seconds
        while name not in self.rows():
            if self.window.poll() is not None:
                raise Failed("the window ended before it showed '%s'" % name)
            if time.monotonic() > end:
                raise Failed("the window does not show '%s'" % name)
            time.sleep(0.05)

    def clock_s(self):
        minutes, seconds = self.text("clock").split(":")
        return 60 * int(minutes) + float(seconds)

    def inserted_mm(self, device):
        found = re.search(r"  (-?\d+) mm", self.text("row %d" % device))
        return int(found.group(1)) if found else 0

    def turned_deg(self, device):
        found = re.search(r"mm  ([+-]\d+)", self.text("row %d" % device))
        return int(found.group(1)) if found else 0

    def tip(self, device):
        """Returns the vessel in which a device's tip lies, and how many millimetres the tip is inside it, as the
        tooltip of the device's row shows them."""
        found = re.match(r"(-?[\d.]+) mm inside (.*)", self.text("tip %d" % device))
        return (float(found.group(1)), found.group(2)) if found else (0.0, "?")

    def bar(self):
        found = re.match(r"(-?[\d.]+) bar", self.text("pressure"))
        return float(found.group(1)) if found else 0.0


class Hand:
    """Presses keys and mouse buttons, and counts these actions."""

    def __init__(self, screen, environment, is_quiet):
        self.screen, self.environment, self.is_quiet = screen, environment, is_quiet
        self.actions = 0

    def tool(self, *words):
        subprocess.run(["xdotool", *words], env=self.environment, check=True, timeout=60)

    def tell(self, what):
        self.actions += 1
        if self.is_quiet:
            return
        rows = [self.screen.inserted_mm(device) for device in (1, 2, 3)]
        tips = [self.screen.text("tip %d" % device) for device in (1, 2, 3)]
        shown = (self.actions, what, self.screen.text("clock"), rows, tips, self.screen.bar())
        print("%2d %-14s %s | %s | %s | %s bar" % shown, flush=True)

    def key(self, name):
        self.tool("key", name)
        self.tell(name)
        time.sleep(0.15)

    def click(self, name):
        x, y = self.screen.place(name)
        search = ["xdotool", "search", "--onlyvisible", "--name", "^Cournand$"]
        found = subprocess.run(search, env=self.environment, capture_output=True, text=True, check=True)
        self.tool("mousemove", "--window", found.stdout.split()[-1], str(x), str(y), "click", "1")
        self.tell("click " + name)

    def hold(self, keys, until, seconds):
        """Holds a key, or several keys as in `shift Up`, until the condition `until` is true on the screen, or until
        the session has advanced by `seconds`. Returns whether the condition `until` became true."""
        names = keys.split()
        begin = self.screen.clock_s()
        self.tool(*[word for name in names for word in ("keydown", name)])
        is_seen = False
        while not is_seen and self.screen.clock_s() - begin < seconds:
            if self.screen.window.poll() is not None:
                raise Failed("the window ended while '%s' was held" % keys)
            time.sleep(0.01)
            is_seen = until()
        self.tool(*[word for name in reversed(names) for word in ("keyup", name)])
        time.sleep(0.2)
        self.tell("%s%s" % (keys, "" if is_seen else " (for %d s)" % seconds))
        return is_seen

    def push(self, device, to_mm, seconds=90, keys="Up"):
        return self.hold(keys, lambda: self.screen.inserted_mm(device) >= to_mm, seconds)

    def pull(self, device, to_mm, seconds=90, keys="Down"):
        return self.hold(keys, lambda: self.screen.inserted_mm(device) <= to_mm, seconds)

    def take(self, device):
        self.key(str(device))

    def watch(self, until, seconds):
        """Looks at the screen until the session has advanced by `seconds`; this does not count as an action. Returns
        whether the condition `until` became true on the screen."""
        end = self.screen.clock_s() + seconds
        is_seen = False
        while self.screen.clock_s() < end:
            time.sleep(0.02)
            is_seen = is_seen or until()
        return is_seen

    def rest(self, seconds):
        self.watch(lambda: False, seconds)


def lay_out(hand):
    """Unloads the devices that this script does not use, and loads the devices that it uses."""
    for wanted in (False, True):
        for name, row in sorted(hand.screen.rows().items()):
            if not name.startswith("cabinet "):
                continue
            is_used = any(device in row[5] for device in DEVICES)
            if is_used == wanted and row[5].startswith("on the line") != wanted:
                hand.click(name.replace("cabinet", "device"))
                time.sleep(0.5)


def open_case(hand):
    """Goes from the start screen through the case's description and the preparation to the session."""
    hand.screen.wait("card 1", 60)
    focus(hand.environment)
    time.sleep(0.5)
    hand.key("Next")  # the second page of cards; X names the key Page Down so
    hand.screen.wait("card 10", 60)
    hand.click("card 10")
    hand.screen.wait("cabinet 1", 60)
    lay_out(hand)
    hand.screen.wait("ready", 900)
    hand.key("Return")
    hand.screen.wait("row 1", 120)
    time.sleep(1.0)


def is_inside(screen, device, vessel, least_mm):
    inside_mm, found = screen.tip(device)
    return found == vessel and inside_mm >= least_mm


def lead_guide(hand):
    """Advances wire, balloon catheter and guide together up the aorta, with the wire ahead. Then the guide slides over
    wire and balloon catheter round the arch and down into the left main artery."""
    screen = hand.screen
    hand.key("f")
    hand.push(WIRE, 37)
    hand.key("g")
    hand.push(GUIDE, 440)
    hand.take(WIRE)
    if not hand.hold("Up", lambda: is_inside(screen, WIRE, "ascending aorta", 40), 30):
        raise Failed("the wire did not go round the arch: %s" % (screen.tip(WIRE),))
    hand.take(BALLOON)
    hand.push(BALLOON, 715)
    hand.take(GUIDE)
    hand.push(GUIDE, 740)
    hand.take(WIRE)
    hand.pull(WIRE, 620)
    hand.take(BALLOON)
    hand.pull(BALLOON, 620)
    hand.take(GUIDE)
    hand.hold("Up", lambda: is_inside(screen, GUIDE, "LM", 2) or screen.inserted_mm(GUIDE) >= 888, 15)
    # The heart moves the ostium, so the guide is looked at for two beats.
    if not hand.watch(lambda: screen.tip(GUIDE)[1] == "LM", 2):
        raise Failed("the guiding catheter is not in the left main: %s" % (screen.tip(GUIDE),))


def show_artery(hand):
    """Makes a cine run with an injection of 8 ml of contrast medium, by pressing two keys at the same time; fluoroscopy
    is off meanwhile."""
    begin = hand.screen.clock_s()
    hand.tool("keydown", "c")
    hand.rest(0.8)
    hand.hold("e", lambda: hand.screen.clock_s() - begin > 2.8, 10)
    hand.rest(1.0)
    hand.tool("keyup", "c")
    hand.tell("c")


def push_gently(hand):
    """Pushes the wire slowly until its tip is beyond the narrow place, has entered a vessel other than the target
    artery, or is stuck. Returns whether the tip was beyond the narrow place when the push ended. The wire moves with
    the heartbeat, so the tip may be in front of the narrow place again at a later moment."""
    screen = hand.screen
    seen = {"best_mm": 0.0, "since_s": screen.clock_s(), "is_across": False}

    def is_decided():
        inside_mm, vessel = screen.tip(WIRE)
        seen["is_across"] = vessel == "LAD" and inside_mm >= ACROSS_MM
        if seen["is_across"] or (vessel not in ON_THE_WAY and inside_mm > ASTRAY_MM):
            return True
        if vessel == "LAD" and inside_mm > seen["best_mm"] + 1 or screen.inserted_mm(WIRE) < 905:
            seen["best_mm"] = max(inside_mm if vessel == "LAD" else 0.0, seen["best_mm"])
            seen["since_s"] = screen.clock_s()
        return screen.clock_s() - seen["since_s"] > STUCK_S

    hand.hold("shift Up", is_decided, 60)
    return seen["is_across"]


def cross(hand):
    """Pushes the wire slowly out of the guide. If the wire enters another vessel or is stuck, the script pulls it back
    out of that vessel, turns it and pushes it again."""
    screen = hand.screen
    hand.take(WIRE)
    hand.push(WIRE, 880)
    for _ in range(TRIES_MAX):
        if push_gently(hand):
            return
        is_beyond_left_main = screen.tip(WIRE)[1] in ("LAD", "D1", "D2")
        hand.pull(WIRE, screen.inserted_mm(WIRE) - 25 if is_beyond_left_main else 890)
        before = screen.turned_deg(WIRE)
        hand.hold("shift Right", lambda: abs(screen.turned_deg(WIRE) - before) >= TURN_DEG - 5, 8)
    raise Failed("the wire is not in the LAD after %d tries: %s" % (TRIES_MAX, screen.tip(WIRE)))


def inflate(hand, bar, rest_s):
    """The script releases the key a little before the wanted pressure, because the pressure rises by 1 bar per second
    until the release."""
    hand.hold("u", lambda: hand.screen.bar() >= bar - 0.2, 30)
    hand.rest(rest_s)
    hand.hold("shift u", lambda: hand.screen.bar() <= 0.05, 15)


def mean_tip_mm(hand):
    """The balloon moves with the heart, so its position is the mean over two heartbeats. Outside the target artery, the
    balloon's position counts as 0."""
    seen = []

    def look():
        inside_mm, vessel = hand.screen.tip(BALLOON)
        seen.append(inside_mm if vessel == "LAD" else 0.0)
        return False

    hand.watch(look, 1.8)
    return sum(seen) / max(len(seen), 1)


def place_balloon(hand):
    """Pushes the balloon to the end of the guide, and then slowly on, until the balloon's middle is in the narrow
    place. Then the script measures the balloon's position over two heartbeats, and corrects an error of more than 1.5
    mm."""
    tip_mm = LESION_MM + BALLOON_MIDDLE_MM
    hand.push(BALLOON, 885)
    hand.hold("shift Up", lambda: is_inside(hand.screen, BALLOON, "LAD", tip_mm), 30)
    for _ in range(2):
        off_mm = tip_mm - mean_tip_mm(hand)
        if abs(off_mm) <= OFF_MM:
            return
        if off_mm > 0:
            hand.push(BALLOON, hand.screen.inserted_mm(BALLOON) + off_mm, 10, "shift Up")
        else:
            hand.pull(BALLOON, hand.screen.inserted_mm(BALLOON) + off_mm, 10, "shift Down")


def treat(hand):
    """Inflates the bare balloon, pulls it out, and deploys a stent from a second balloon. If the residual stenosis or
    the struts then miss their goals, the balloon is inflated once more inside the stent."""
    hand.take(BALLOON)
    place_balloon(hand)
    inflate(hand, 8, 3)
    hand.pull(BALLOON, 0)
    hand.key("9")
    place_balloon(hand)
    inflate(hand, 16, 10)
    for _ in range(POST_MAX):
        hand.rest(1)
        if RESULT_GOALS <= set(hand.screen.rows()):
            break
        inflate(hand, 16, 10)
    hand.pull(BALLOON, 870)


def play(hand):
    open_case(hand)
    lead_guide(hand)
    hand.key("f")
    hand.key("F5")  # RAO cranial, the view of this artery
    hand.rest(4)
    show_artery(hand)
    hand.key("f")
    cross(hand)
    treat(hand)
    hand.key("f")
    hand.rest(1)
    show_artery(hand)
    hand.key("Escape")
    hand.screen.wait("score", 1800)
    return float(hand.screen.text("score").split()[0])


def measure(options, is_quiet=True, record=""):
    """Plays the case; returns the line with the measured number of actions. Ends the program with a message if a step
    fails."""
    begin = time.monotonic()
    words = ["--start", "--size", "128"] + (["--record", record] if record else [])
    with window_of(options, words, has_layout=True) as (window, environment, folder):
        hand = Hand(Screen(os.path.join(folder, "layout"), window), environment, is_quiet)
        try:
            score = play(hand)
        except Failed as failure:
            sys.exit("pci_by_hand.py: after %d actions: %s" % (hand.actions, failure))
    minutes = (time.monotonic() - begin) / 60
    context = "case=lad_stent score=%.0f minutes=%.0f" % (score, minutes)
    return ("suite.pci_actions", str(hand.actions), "actions", context)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", default="build")
    parser.add_argument("--record", default="", help="write the recording of the session into this file")
    parser.add_argument("--quiet", action="store_true", help="do not print each action")
    options = parser.parse_args()
    row = measure(options, options.quiet, options.record)
    print("\t".join(row))
    if int(row[1]) > ACTIONS_MAX:
        sys.exit("pci_by_hand.py: more than %d actions" % ACTIONS_MAX)


if __name__ == "__main__":
    main()
