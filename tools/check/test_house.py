#!/usr/bin/env python3
"""The rooms of the house stand in no circle, and nothing in it has outgrown its limit (docs/architecture.md). Prints TAP."""

import house
import tree


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
    # Tests of the command line itself: its commands beside a lying device, and its keys.
    allowed = [
        "hil_tests/lies/commands.cpp includes host/app/cli.hpp",
        "host/session/tests/test_tools.cpp includes host/app/window_keys.hpp",
    ]
    report.check(
        "no tool leans on the program", [one for one in found["house.tools_on_program"][1] if one not in allowed]
    )
    report.end()


if __name__ == "__main__":
    main()
