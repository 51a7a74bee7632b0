#!/usr/bin/env python3
"""Traces each safety requirement to code and tests, and writes the tables of docs/safety.md.

  trace_safety.py            check, and compare the tables of the page with tools/safety/safety_file.toml and the tags
  trace_safety.py --write    write the tables

A tag is a comment with the word `Requirement` and one or more numbers above a function, in C, C++ or Python:

    /* Requirement: SR-03 */

Exit code 1: a requirement has no code or no test, a tag or a hazard names no requirement, a folder belongs to no
software item, or the page is not up to date.
"""

import argparse
import os
import re
import sys
import tomllib

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import tree  # noqa: E402

DATA = "tools/safety/safety_file.toml"
PAGE = "docs/safety.md"
ROOMS = ("firmware", "hil_tests", "host", "shared", "tools")
TAG = re.compile(r"^[ \t]*(?:/\*|//|#) Requirement: (SR-\d+(?:, SR-\d+)*)(?: \*/)?[ \t]*$", re.M)
FUNCTION = re.compile(r"(?:def |\b)(\w+)\(")
NOT_NAMES = ("__attribute__", "section", "used", "aligned", "noreturn")
ACCEPTED = 4  # largest product of severity and probability that is accepted without further reasons


def is_test(path):
    return "/tests/" in path or path.startswith("hil_tests/") or os.path.basename(path).startswith("test_")


def name_below(text, position):
    """Returns the name of the first function below a tag."""
    for match in FUNCTION.finditer(text, position):
        if match.group(1) not in NOT_NAMES:
            return match.group(1)
    return "?"


def tags():
    """Yields (requirement, path, function) of every tag."""
    for path in tree.files(".c", ".h", ".cpp", ".hpp", ".py"):
        if not path.startswith(ROOMS) or path == "tools/safety/trace_safety.py":
            continue
        text = tree.read(path)
        if "Requirement: SR-" not in text:
            continue
        for match in TAG.finditer(text):
            for requirement in match.group(1).split(", "):
                yield requirement, path, name_below(text, match.end())


def data():
    with open(os.path.join(ROOT, DATA), "rb") as file:
        return tomllib.load(file)


def trace_of(found):
    """Returns {requirement: (code, tests)}, each a list of (path, function)."""
    trace = {}
    for requirement, path, name in found:
        trace.setdefault(requirement, ([], []))[is_test(path)].append((path, name))
    return trace


def faults_of(file, trace, folders):
    """Yields one line for each gap of the trace."""
    known = [requirement["id"] for requirement in file["requirement"]]
    controls = {control for hazard in file["hazard"] for control in hazard["controls"]}
    for twice in sorted({number for number in known if known.count(number) > 1}):
        yield "%s stands twice" % twice
    for number in known:
        code, tests = trace.get(number, ([], []))
        if not code:
            yield "%s has no code: tag a function with it" % number
        if not tests:
            yield "%s has no test: tag one with it" % number
        if number not in controls:
            yield "%s controls no hazard" % number
    for number in sorted(set(trace) - set(known)):
        yield "a tag names %s, which is no requirement: %s" % (number, (trace[number][0] + trace[number][1])[0][0])
    for number in sorted(controls - set(known)):
        yield "a hazard names %s, which is no requirement" % number
    for hazard in file["hazard"]:
        if hazard["severity"] * hazard["after"] > ACCEPTED and not hazard.get("residual"):
            yield "%s keeps a risk of %d without a reason" % (hazard["id"], hazard["severity"] * hazard["after"])
    for folder in folders:
        if item_of(file, folder) is None:
            yield "the folder %s belongs to no software item" % folder


def item_of(file, folder):
    """Returns the software item of a folder, that with the longest matching name, or None."""
    fits = [
        (len(prefix), item["name"])
        for item in file["item"]
        for prefix in item["folders"]
        if (folder + "/").startswith(prefix + "/")
    ]
    return max(fits)[1] if fits else None


def source_folders():
    return sorted({os.path.dirname(path) for path in tree.files(*tree.C_SUFFIXES) if path.startswith(ROOMS)})


def text_of(places):
    lines = {}
    for path, name in places:
        lines.setdefault(path, []).append("`%s`" % name)
    return "; ".join("%s: %s" % (path, ", ".join(names)) for path, names in sorted(lines.items()))


def tables(file, trace):
    """Returns {name: Markdown table}."""
    hazards = [
        "| hazard | how it happens | harm | S | P before | P after | controls |",
        "|---|---|---|---|---|---|---|",
    ]
    for hazard in file["hazard"]:
        hazards.append(
            "| %(id)s: %(hazard)s | %(sequence)s | %(harm)s | S%(severity)d | P%(before)d | P%(after)d |" % hazard
            + " %s |" % ", ".join(hazard["controls"])
        )
    requirements = ["| requirement | code | tests |", "|---|---|---|"]
    for requirement in file["requirement"]:
        code, tests = trace[requirement["id"]]
        requirements.append(
            "| %s. %s | %s | %s |" % (requirement["id"], requirement["text"], text_of(code), text_of(tests))
        )
    items = ["| item | folders | class | reason |", "|---|---|---|---|"]
    for item in file["item"]:
        folders = ", ".join("`%s`" % folder for folder in item["folders"])
        items.append("| %s | %s | %s | %s |" % (item["name"], folders, item["class"], item["reason"]))
    return {"hazards": hazards, "requirements": requirements, "items": items}


def filled(page, written):
    """Returns the page with its tables replaced."""
    for name, lines in written.items():
        begin, end = "<!-- begin %s -->" % name, "<!-- end %s -->" % name
        head, rest = page.split(begin)
        page = head + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1]
    return page


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--write", action="store_true", help="write the tables of %s" % PAGE)
    given = parser.parse_args()
    file, trace = data(), trace_of(tags())
    faults = list(faults_of(file, trace, source_folders()))
    if not faults:
        page = tree.read(PAGE)
        new = filled(page, tables(file, trace))
        if given.write:
            with open(os.path.join(ROOT, PAGE), "w", encoding="utf-8") as output:
                output.write(new)
        elif new != page:
            faults.append("%s is not up to date. Remedy: tools/safety/trace_safety.py --write" % PAGE)
    for fault in faults:
        print(fault)
    if not faults:
        places = sum(len(code) + len(tests) for code, tests in trace.values())
        print("%d hazards, %d requirements, %d tags" % (len(file["hazard"]), len(file["requirement"]), places))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
