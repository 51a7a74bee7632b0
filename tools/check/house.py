#!/usr/bin/env python3
"""Measures the structure of the code: circular includes between folders ("rooms"), long functions and files, and
crowded folders. The script also counts the folders that depend on the program `cournand`, and measures the size of the
largest struct.

  house.py [--write FILE]

For each figure the script prints a line `name<TAB>value<TAB>unit<TAB>context`, and for every figure that is not 0 it
prints the reasons in comment lines. The option --write appends the figures' lines to FILE (out/bench.tsv) and removes
older lines with the same names. The exit code is 0.
"""

import argparse
import collections
import os
import re
import sys

import tree

sys.path.insert(0, os.path.join(tree.ROOT, "tools", "check", "tests"))
import test_style  # noqa: E402

FOLDER_FILES_MAX = 40
INCLUDE = re.compile(r'^\s*#\s*include "([^"]+)"', re.M)
SOURCE = tree.C_SUFFIXES + (".py", ".sh")


def rooms_graph():
    """Returns a table that maps each folder to the folders from which its files include headers; tests are left out."""
    graph = collections.defaultdict(set)
    for path in tree.files(*tree.C_SUFFIXES, ".inc"):
        room = os.path.dirname(path)
        if "/tests" in path or room.startswith("hil_tests"):
            continue
        for included in INCLUDE.findall(tree.read(path)):
            if "/" in included and os.path.dirname(included) != room:
                graph[room].add(os.path.dirname(included))
    return graph


def reached(graph, start):
    seen, waiting = set(), list(graph.get(start, ()))
    while waiting:
        room = waiting.pop()
        if room not in seen:
            seen.add(room)
            waiting.extend(graph.get(room, ()))
    return seen


def circles(graph):
    """Finds the groups of folders (rooms) that include each other in a circle, and returns each such group once."""
    reach = {room: reached(graph, room) for room in graph}
    found = {
        frozenset(other for other in reach if other in reach[room] and room in reach[other])
        for room in graph
        if room in reach[room]
    }
    return [", ".join(sorted(circle)) for circle in found]


def crowded():
    counts = collections.Counter(os.path.dirname(path) for path in tree.files(*SOURCE))
    return ["%s: %d files" % one for one in counts.most_common() if one[1] > FOLDER_FILES_MAX]


def leaning():
    return [
        "%s includes %s" % (path, included)
        for path in tree.files(*tree.C_SUFFIXES)
        if not path.startswith("host/app/")
        for included in INCLUDE.findall(tree.read(path))
        if included.startswith("host/app/")
    ]


def largest_struct():
    """Returns (members, struct) of firmware/app."""
    most = (0, "")
    for path in tree.files(".h"):
        if not path.startswith("firmware/app/"):
            continue
        for name, body in re.findall(r"struct (\w+) \{\n(.*?)\n\}", tree.code_only(tree.read(path)), re.S):
            members = sum(line.count(",") + 1 for line in body.split("\n") if line.rstrip().endswith(";"))
            most = max(most, (members, name))
    return most


def over(rule, suffixes):
    return [finding for path in tree.files(*suffixes) for finding in rule(path, tree.read(path))]


def figures():
    """Measures the structure of the code, and returns a list of (name, value, unit, context, reasons) with one entry
    per measured figure."""
    members, struct = largest_struct()
    for name, unit, behind in (
        ("house.rooms_circles", "circles", circles(rooms_graph())),
        ("house.functions_over_70", "functions", over(test_style.long_functions, tree.C_SUFFIXES + (".py",))),
        (
            "house.files_over_600",
            "files",
            over(test_style.long_file, tree.C_SUFFIXES + (".py", ".sh", "Makefile", ".mk", ".def")),
        ),
        ("house.folders_over_40", "folders", crowded()),
        ("house.tools_on_program", "includes", leaning()),
    ):
        yield name, len(behind), unit, "", behind
    yield "house.struct_members_max", members, "members", "struct=" + struct, []


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", help="append the lines to this file, too")
    options = parser.parse_args()
    lines = []
    for name, value, unit, context, behind in figures():
        lines.append("%s\t%d\t%s\t%s" % (name, value, unit, context))
        print("\n".join(lines[-1:] + ["# " + one for one in behind]))
    if options.write:
        kept = []
        if os.path.exists(options.write):
            with open(options.write, encoding="utf-8") as file:
                kept = [line for line in file.read().splitlines() if not line.startswith("house.")]
        with open(options.write, "w", encoding="utf-8") as file:
            file.write("\n".join(kept + lines) + "\n")


if __name__ == "__main__":
    main()
