#!/usr/bin/env python3
"""Tests the command lines of all programs, according to the table of commands that the programs themselves print
(--generate man). If an option or subcommand is mistyped, every command names it, suggests the right one, and returns
exit code 2. If an output cannot be written, every command refuses it before the work begins. No program writes progress
into a pipe. Prints TAP.

Each command with outputs needs a line in OUTPUT_CASES; the test fails for a new command without a line. The
test names inputs that do not exist: a command that read its input before it checked its output would complain about the
input."""

import os
import pty
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import command_table  # noqa: E402
import tree  # noqa: E402

TOOL = ["--tool", "j_wire"]
SCENE = '[scene]\nname = "s"\n[lumen]\nmesh = "gone.stl"\nunit = "mm"\n[entry]\nposition_mm = [0, 0, 0]\n'
SCENE += "direction = [0, 1, 0]\n"
# Command -> its other words, with those outputs that it requires.
OUTPUT_CASES = {
    "cournand run": ["--scene", "./gone.scene", "--session", "./gone.session"] + TOOL,
    "cournand replay": ["./gone.rec"],
    "cournand surface": ["./gone.rec", "--at", "1", "-o", "fine.obj"],
    "cournand view": ["--scene", "./gone.scene"] + TOOL,
    "cournand instruments": ["./gone.toml"],
    "cournand rig monitor": ["--device", "sim", "--seconds", "1"],
    "cournand rig calibrate": ["--device", "sim"],
    "cournand patient new": ["--ct", "./gone.nii", "-o", "fine"],
    "anatomy aorta": ["-o", "fine"],
    "anatomy phantom": ["-o", "fine"],
    "anatomy access": ["-o", "fine"],
    "anatomy heart": ["-o", "fine"],
    "anatomy person": ["--seed", "7", "-o", "fine"],
    "anatomy beat": "./gone.ply --left 1 0 0 --right 0 1 0 --apex 0 0 1 -o fine".split(),
    "anatomy draw": ["--seed", "7", "-o", "fine"],
    "bake": ["scene.toml", "-o", "fine.scene"],
    "centreline fit": ["./gone.stl", "--points", "./gone.toml", "-o", "fine.csv"],
    "centreline auto": ["./gone.stl", "-o", "fine.csv"],
    "centreline edit": ["./gone.stl", "--project", "fine.toml"],
    "centreline convert": ["./gone.csv", "-o", "fine.csv"],
    "centreline patient": ["./gone.stl", "-o", "fine"],
    "centreline carry": ["./gone.csv", "frames", "-o", "fine"],
    "centreline show": ["./gone.csv", "--mesh", "./gone.stl", "-o", "fine.png"],
}
# An upgrade plays nothing, so its output goes with other words; a table is renewed, so it must exist.
OTHER_WORDS = {("cournand replay", "--output"): ["--upgrade"]}


class Folder:
    """Makes a folder in which the programs run, with the few files that the test cases name."""

    def __init__(self, path):
        self.path = path
        with open(os.path.join(path, "scene.toml"), "w", encoding="utf-8") as file:
            file.write(SCENE)
        os.mkdir(os.path.join(path, "frames"))
        for name in ("gone.stl", "frames/a_00.obj", "frames/a_01.obj"):
            with open(os.path.join(path, name), "w", encoding="utf-8") as file:
                file.write("no mesh\n")
        with open(os.path.join(path, "file"), "w", encoding="utf-8") as file:
            file.write("no folder\n")

    def run(self, words, **more):
        home = os.path.join(self.path, "home")
        environment = dict(os.environ, DISPLAY="", WAYLAND_DISPLAY="", HOME=home, XDG_STATE_HOME=home)
        return subprocess.run(
            [os.path.join(command_table.BIN, words[0])] + words[1:],
            cwd=self.path,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=more.get("stderr", subprocess.STDOUT),
            text=True,
            errors="replace",
            timeout=300,
            check=False,
        )

    def names(self):
        return sorted(name for name in os.listdir(self.path) if name != "home")


def mistyped(word):
    """Returns the word with two letters exchanged, or with one additional letter if the word is short or the two
    letters are equal."""
    at = len(word) - 2
    changed = word[:at] + word[at + 1] + word[at]
    return changed if changed != word and len(word) > 4 else word + "x"


def suggestion_faults(folder, command):
    """Yields an error for each option or subcommand whose mistyped form is not corrected."""
    cases = [(mistyped(option), option) for option in command.outputs[:2] + command.options[-2:]]
    cases += [(mistyped(name), name) for name in command.below]
    for wrong, right in cases:
        done = folder.run(command.words + [wrong])
        wanted = "'%s', did you mean '%s'?" % (wrong, right)
        if done.returncode != 2 or wanted not in done.stdout:
            yield "%s %s: exit %d, %s" % (" ".join(command.words), wrong, done.returncode, done.stdout[:300])


def check_suggestions(report, folder, commands):
    for command in commands:
        report.check(
            "%s corrects mistyped words" % " ".join(command.words),
            suggestion_faults(folder, command),
        )
    done = folder.run(["cournand", "run", "--tool", "j_wrie"])
    found = done.returncode == 2 and "there is no instrument 'j_wrie', did you mean 'j_wire'?" in done.stdout
    report.check("a mistyped name is corrected", [] if found else [done.stdout])
    done = folder.run(["cournand", "run", "--style", "vcsim"])
    found = done.returncode == 2 and "there is no 'vcsim', did you mean 'vcsim3'?" in done.stdout
    report.check("a mistyped choice is corrected", [] if found else [done.stdout])


def help_faults(folder, command):
    done = folder.run(command.words + ["--help"])
    if done.returncode != 0:
        yield "exit %d" % done.returncode
    if not command.below and "Examples:" not in done.stdout and command.words[0] == "cournand":
        yield "it has no example"
    for line in done.stdout.split("\n"):
        if len(line) > 100 and not line.startswith("  "):
            yield "more than 100 letters: " + line


def check_help(report, folder, commands):
    faults = [
        "%s: %s" % (" ".join(command.words), text) for command in commands for text in help_faults(folder, command)
    ]
    report.check("every command explains itself, with an example and lines that fit", faults)


def output_faults(folder, command, words):
    before = folder.names()
    for option in command.outputs:
        key = " ".join(command.words)
        place = "file/below" if option == "--output" and "fine" in words else "missing/fine.out"
        if option == "--dicom":
            place = "file/below"
        used = [word for word in words]
        for name in (option, "-o" if option == "--output" else option):
            if name in used:
                used[used.index(name) + 1] = place
                break
        else:
            used += OTHER_WORDS.get((key, option), []) + [option, place]
        done = folder.run(command.words + used)
        if done.returncode != 1 or place.split("/")[0] not in done.stdout:
            yield "%s %s: exit %d, %s" % (key, " ".join(used), done.returncode, done.stdout[:300])
    if folder.names() != before:
        yield "it left %s" % sorted(set(folder.names()) - set(before))


def check_outputs(report, folder, commands):
    for command in commands:
        key = " ".join(command.words)
        if not command.outputs:
            continue
        words = OUTPUT_CASES.get(key)
        report.check(
            "%s checks its outputs before its work" % key,
            ["OUTPUT_CASES lacks it"] if words is None else output_faults(folder, command, words),
        )


def terminal_text(folder, words):
    """Returns what a program writes to standard error if standard error is a terminal."""
    ours, theirs = pty.openpty()
    folder.run(words, stderr=theirs)
    os.close(theirs)
    text = b""
    try:
        while True:
            piece = os.read(ours, 65536)
            if not piece:
                break
            text += piece
    except OSError:
        pass
    os.close(ours)
    return text.decode(errors="replace")


def check_progress(report, folder):
    cases = {
        "cournand": ["cournand", "run", "--session", "free_space"] + TOOL,
        "anatomy": ["anatomy", "phantom", "--no-bodies", "--lumen-mm", "2", "-o", "phantom"],
        "bake": ["bake", "phantom/scene.toml", "-o", "phantom.scene", "--points", "1000", "--poses", "0"],
        "centreline": ["centreline", "auto", "phantom/scene.toml", "-o", "phantom.csv"],
    }
    for name, words in cases.items():
        done = folder.run(words, stderr=subprocess.PIPE)
        found = [] if done.returncode == 0 and done.stderr == "" else ["%d: %s" % (done.returncode, done.stderr)]
        report.check("%s writes no progress into a pipe" % name, found)
        if name != "centreline":  # it may be too fast to show any
            longer = ["600000" if word == "1000" else word for word in words]  # a stage below a second shows none
            text = terminal_text(folder, longer)
            report.check("%s shows its progress on a terminal" % name, [] if text else ["nothing was shown"])


def check_elsewhere(report, folder):
    done = folder.run(["cournand", "instruments"])
    lines = [line for line in done.stdout.split("\n") if line.startswith("j_wire ")]
    report.check(
        "the instruments that come with the program are listed from every folder",
        [] if done.returncode == 0 and lines else [done.stdout],
    )


def main():
    report = tree.Report()
    commands = command_table.commands()
    with tempfile.TemporaryDirectory() as path:
        folder = Folder(path)
        check_suggestions(report, folder, commands)
        check_help(report, folder, commands)
        check_outputs(report, folder, commands)
        check_elsewhere(report, folder)
        check_progress(report, folder)
    report.end()


if __name__ == "__main__":
    main()
