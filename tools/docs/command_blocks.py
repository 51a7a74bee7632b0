"""Finds the shell commands in the project's Markdown files, and the class of each command. The program commands.py
explains the terms "block", "marker" and "class"."""

import collections
import re

# Class -> (the runs in which a command of the class is executed, why not in the others)
CLASSES = {
    "short": (("short", "all"), ""),
    "make": ((), "it builds or measures for minutes to hours, and is dry run: make -n"),
    "lab": (("all",), "it takes minutes"),
    "display": (("all",), "it opens a window, which is closed again after seconds"),
    "anatomy": (("all",), "it needs the anatomy beside the repository, ../shared/anatomy"),
    "hardware": ((), "it needs a rig on USB"),
    "guest": ((), "it starts a guest with a kernel of its own; make hil-guest runs it"),
    "debugger": ((), "it waits for a debugger, or for the image that one is to look at"),
    "hours": ((), "it runs for hours"),
    "package": ((), "it needs the Python package: see test_python_install.py and test_python_tasks.py"),
    "system": ((), "it changes the machine; test_deb_installed.sh does so in a bare Debian, make test-hours"),
    "template": ((), "its names stand for the reader's own files"),
    "output": ((), "it is what a program prints, and no command"),
}
MARK = re.compile(r"^<!-- command: ((?:(?!-->).)+?) -->$", re.MULTILINE | re.DOTALL)
MARK_PARTS = re.compile(r"^(?P<kind>\w+)(?P<rest>(?:; (?:exit|only|with|adding) [^;]+)*)$")
STARTS = re.compile(
    r"(?:sudo |until |(?:[A-Z][A-Z_0-9]*=\S* ))*"
    r"(?:make|cmake|ctest|ninja|git|cd|apt|apt-get|pip|pip3|python3?|pkg-config|mpirun|"
    r"gdb-multiarch|gdb|tshark|wireshark|ffmpeg|"
    r"docker|podman|debootstrap|mmdebstrap|udevadm|lsusb|cournand|bake|anatomy|centreline|"
    r"(?:\./|build/|tools/|hil_tests/|host/|firmware/|\.ci/)[\w./-]+)(?:\s|$)"
)
SHELLS = ("", "sh", "bash", "console", "shell", "text")
FENCE = re.compile(r"^ {0,3}(```+|~~~+) *(\w*)")

Command = collections.namedtuple("Command", "page line text kind exit words_with words_added")


class MarkError(Exception):
    """Raised for a marker (a comment that classifies commands) that cannot be interpreted."""


def blocks(lines):
    """Yields (number of the first line, lines) of every indented block, and of every fenced block that may hold
    commands. Line numbers begin at 1."""
    at, before = 0, ""
    while at < len(lines):
        fence = FENCE.match(lines[at])
        begin = at
        if fence:
            at += 1
            while at < len(lines) and not lines[at].strip().startswith(fence.group(1)):
                at += 1
            if fence.group(2) in SHELLS:
                yield begin + 2, lines[begin + 1 : at]
            at += 1
        elif lines[at].startswith("    ") and (not before.strip() or before.startswith("#") or before.endswith("-->")):
            while at < len(lines) and (
                lines[at].startswith("    ") or (not lines[at].strip() and is_indented(lines, at + 1))
            ):
                at += 1
            yield begin + 1, [line[4:] for line in lines[begin:at]]
        else:
            at += 1
        before = lines[at - 1]


def is_indented(lines, at):
    return at < len(lines) and lines[at].startswith("    ")


def marks_of(page, text):
    """Returns a table that maps the number of a marker's last line to the parsed marker. Line numbers begin at
    1."""
    found = {}
    for match in MARK.finditer(text):
        first = text.count("\n", 0, match.start()) + 1
        found[text.count("\n", 0, match.end()) + 1] = read_mark(page, first, " ".join(match.group(1).split()))
    return found


def marks_above(lines, first, marks):
    """Returns the markers directly above a block of commands; if the block is fenced, these are the markers directly
    above its fence."""
    at = first - 1  # the line above, counted from 1
    if at >= 1 and FENCE.match(lines[at - 1]):
        at -= 1
    found = []
    while at >= 1 and (at in marks or not lines[at - 1].strip()):
        if at in marks:
            found.append(marks[at])
            at = marks[at]["line"]
        at -= 1
    return found[::-1]


def read_mark(page, line, text):
    """Returns {kind, exit, only, with, adding}."""
    parts = MARK_PARTS.match(text)
    if not parts or parts.group("kind") not in CLASSES:
        raise MarkError(
            "%s:%d: '%s' is no marker: <!-- command: CLASS[; exit N][; only TEXT][; with A=B][; adding WORDS] -->,"
            " CLASS one of %s" % (page, line, text, " ".join(sorted(CLASSES)))
        )
    mark = {"kind": parts.group("kind"), "line": line, "used": False}
    for part in parts.group("rest").split("; ")[1:]:
        key, value = part.split(" ", 1)
        mark[key] = value
    return mark


def commands_of_block(first, lines):
    """Yields (line number, text) of every command in a block, after joining the command's continuation lines."""
    prompted = any(line.startswith("$ ") for line in lines)
    at = 0
    while at < len(lines):
        line, begin = lines[at], at
        at += 1
        if prompted:
            if not line.startswith("$ "):
                continue
            line = line[2:]
        if not (prompted or STARTS.match(line)):
            continue
        while line.endswith("\\") and at < len(lines):
            line = line[:-1].rstrip() + " " + lines[at].strip()
            at += 1
        yield first + begin, line.rstrip()


def classified(page, line, text, marks):
    """Returns the command with its class, which decides whether commands.py runs the command. The class of a
    command comes from the first marker (HTML comment) that names the command. If no marker names the command, its class
    comes from the first marker (HTML comment) for the whole block."""
    is_make = text.split()[0] == "make"
    named = [mark for mark in marks if "only" in mark and mark["only"] in text]
    whole = [mark for mark in marks if "only" not in mark]
    mark = (named + ([] if is_make else whole) or [{}])[0]
    mark["used"] = True
    kind = mark.get("kind") or ("make" if is_make else "short")
    pairs = [pair.split("=", 1) for pair in mark.get("with", "").split()]
    return Command(page, line, text, kind, int(mark.get("exit", 0)), pairs, mark.get("adding", ""))


def commands(page, text):
    """Returns every command of a Markdown page, but not the lines that only show a command's output. Raises
    MarkError."""
    lines, marks = text.split("\n"), marks_of(page, text)
    found = []
    for first, block in blocks(lines):
        above = marks_above(lines, first, marks)
        found += [classified(page, line, words, above) for line, words in commands_of_block(first, block)]
    for mark in marks.values():
        if not mark["used"]:
            raise MarkError("%s:%d: this marker fits no command of a block right below it" % (page, mark["line"]))
    return [one for one in found if one.kind != "output"]
