#!/usr/bin/env python3
"""Checks that the program output shown in the documents equals what the programs print today.

  printed.py --write     run every command and write its lines into the documents
  printed.py --check     exit 1 when a document shows other lines

A line `<!-- printed by: COMMAND -->` in a document marks a block of program output. The first indented line below the
mark is the command with `$`; the following indented lines are lines that the command prints on standard output. In the
block, a line `...` stands for omitted lines of output up to the next shown line or the end. COMMAND runs in the root
folder of the repository, and the word `cournand` in COMMAND means build/bin/cournand.
"""

import argparse
import os
import re
import subprocess
import sys

MARK = re.compile(r"^<!-- printed by: (.+) -->$")
SHOWN = "    "


def blocks(lines):
    """Yields, for every marked block, its command, the number of its first line, and the number of the line after its
    last line."""
    at = 0
    while at < len(lines):
        mark = MARK.match(lines[at])
        at += 1
        if not mark:
            continue
        begin = at
        while at < len(lines) and lines[at].startswith(SHOWN):
            at += 1
        yield mark.group(1), begin, at


def output_of(command, build):
    words = command.replace("cournand ", os.path.join(build, "bin", "cournand") + " ", 1)
    done = subprocess.run(
        ["bash", "-c", words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        timeout=60,
    )
    if done.returncode != 0:
        raise RuntimeError("'%s' ended with %d: %s" % (command, done.returncode, done.stderr.strip()))
    return [line.rstrip() for line in done.stdout.splitlines()]


def renewed(shown, printed):
    """Returns the new output lines for a document: as many lines as it shows now, with `...` at the same positions."""
    result, at = [], 0
    parts = [[]]
    for line in shown:
        if line == "...":
            parts.append([])
        else:
            parts[-1].append(line)
    for number, part in enumerate(parts):
        if number > 0:
            result.append("...")
            # The first word gives the place where the program's lines continue.
            first = part[0].split()[:1] if part else []
            at = (
                next((i for i in range(at, len(printed)) if printed[i].split()[:1] == first), len(printed))
                if part
                else at
            )
        result += printed[at : at + len(part)]
        at += len(part)
    if len(parts) == 1 and len(printed) > len(shown):
        result += printed[at:]
    return result


def examine(path, build):
    """Returns the document with up-to-date program output, and a message for each block whose output has changed."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    differences, pieces, last = [], [], 0
    for command, begin, end in blocks(lines):
        shown = [line[len(SHOWN) :].rstrip() for line in lines[begin:end]]
        title = "$ " + command
        wanted = [title] + renewed(
            shown[1:] if shown and shown[0].startswith("$ ") else shown, output_of(command, build)
        )
        if wanted != shown:
            differences.append("%s:%d: '%s' prints something else now; run: make docs" % (path, begin + 1, command))
        pieces += lines[last:begin] + [(SHOWN + line).rstrip() for line in wanted]
        last = end
    return "\n".join(pieces + lines[last:]), differences


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--write", action="store_true")
    action.add_argument("--check", action="store_true")
    parser.add_argument("--build", default=os.environ.get("BUILD", "build"))
    options = parser.parse_args()
    found = []
    for name in ["README.md"] + sorted("docs/" + n for n in os.listdir("docs") if n.endswith(".md")):
        text, differences = examine(name, options.build)
        found += differences
        if options.write and differences:
            with open(name, "w", encoding="utf-8") as file:
                file.write(text)
            print("Written: " + name)
    if options.check:
        print("\n".join(found) if found else "every marked block is what its command prints")
    return 1 if options.check and found else 0


if __name__ == "__main__":
    sys.exit(main())
