#!/usr/bin/env python3
"""These tests check the following. The source folders (rooms) have no circular includes, and no file, function or
folder exceeds its size limit (docs/architecture.md). Prints TAP."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import house  # noqa: E402
import tree  # noqa: E402


def main():
    report = tree.Report()
    report.check(
        "two rooms that lean on each other are a circle",
        [] if house.circles({"a": {"b"}, "b": {"a"}}) == ["a, b"] else ["not found"],
    )
    report.check(
        "so are three",
        [] if house.circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == ["a, b, c"] else ["not found"],
    )
    report.check("a stair is none", house.circles({"a": {"b", "c"}, "b": {"c"}}))
    found = {name: (value, behind) for name, value, _, _, behind in house.figures()}
    report.check("rooms are found", [] if len(house.rooms_graph()) > 30 else ["only %d" % len(house.rooms_graph())])
    for name, sentence in (
        ("house.rooms_circles", "no rooms stand in a circle"),
        ("house.functions_over_70", "no function is longer than 70 lines"),
        ("house.files_over_600", "no file is longer than 600 lines"),
    ):
        report.check(sentence, found[name][1])
    report.check("no tool leans on the program", found["house.tools_on_program"][1])
    report.check("no folder has more than 40 source files", found["house.folders_over_40"][1])
    report.end()


if __name__ == "__main__":
    main()
