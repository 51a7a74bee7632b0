#!/usr/bin/env python3
"""These tests check the following. The program sentences.py prints the same sample whenever the seed is the same,
and every line of the sample is a sentence. Prints TAP."""

import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), ".."))
sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "check"))
import sentences  # noqa: E402
import tree  # noqa: E402

DOCUMENT = """# A heading is no sentence at all here
A wire of 0.36 mm goes into the left main artery. It [rests](rest.md) on the wall of the vessel
and turns by 3.5 degrees there.

    code --is no sentence that anybody reads

| a table | is none either, whatever it says in it. |

<!-- begin messages -->
What a program writes into this page is no sentence of ours.
<!-- end messages -->
- An item of a list is a sentence like any other one.
"""
SOURCE = """// The tube is long enough for every wire that ships. See there.
//
//   tube = make_tube();   this line shows how it is called, and is left out.
int a; /* It counts every tick that was late by more than 1 ms. */
int b; // the number of late ticks since the last start of the program
       // A comment below a label is a comment of its own here.
// Format: 64 bit -> 64 bit, and this line is no sentence.
"""
SCRIPT = '''"""A docstring is read as any other comment is read."""
TEXT = """Text that a program prints is no comment of ours."""
PATHS = glob("/lib/*/bin/one"); each of these paths names a program of the server. OTHER = "*/"
'''


def run(*words):
    return subprocess.run(
        [os.path.join(os.path.dirname(__file__), "..", "sentences.py")] + list(words),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )


def main():
    report = tree.Report()
    found = list(sentences.of_document(DOCUMENT))
    report.check(
        "paragraphs and items are split, code and tables are left out",
        []
        if found
        == [
            "A wire of 0.36 mm goes into the left main artery.",
            "It rests on the wall of the vessel and turns by 3.5 degrees there.",
            "An item of a list is a sentence like any other one.",
        ]
        else found,
    )
    found = list(sentences.of_source(SOURCE))
    report.check(
        "so are comments, without their examples",
        []
        if found
        == [
            "The tube is long enough for every wire that ships.",
            "It counts every tick that was late by more than 1 ms.",
            "A comment below a label is a comment of its own here.",
        ]
        else found,
    )
    found = list(sentences.of_script(SCRIPT))
    report.check("and docstrings", [] if found == ["A docstring is read as any other comment is read."] else found)
    one, again, other = run("--seed", "3"), run("--seed", "3"), run("--seed", "4")
    report.check(
        "a seed gives sixty sentences, the same every time",
        []
        if one.returncode == 0 and one.stdout == again.stdout != other.stdout and one.stdout.count("\n") == 60
        else [one.stderr],
    )
    part = run("--seed", "3", "--count", "5", "--file", "docs/rod", "--file", "host/xray/").stdout.splitlines()
    report.check(
        "--file takes only paths that begin so",
        []
        if len(part) == 5 and all(line.split("\t")[1].startswith(("docs/rod", "host/xray/")) for line in part)
        else part,
    )
    report.check(
        "more than there are is wrong usage", [] if run("--count", "1000000").returncode == 2 else ["accepted"]
    )
    report.end()


if __name__ == "__main__":
    main()
