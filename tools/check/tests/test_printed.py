#!/usr/bin/env python3
"""These tests check the following. The program output that the documents show equals what the programs print
today, and the documents name the present versions."""

import os
import re
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "docs"))
import pictures  # noqa: E402
import printed  # noqa: E402

count, failed = 0, 0


def claim(ok, name, why=""):
    global count, failed
    count += 1
    failed += not ok
    print("%sok %d - %s" % ("" if ok else "not ", count, name))
    for line in [] if ok else why.splitlines():
        print("# " + line)


def examined(text):
    with tempfile.NamedTemporaryFile("w", suffix=".md", delete=False) as file:
        file.write(text)
    try:
        return printed.examine(file.name, "build")
    finally:
        os.unlink(file.name)


def named_cores(text):
    """Returns the core versions that occur in the program output and in the written tables of a document."""
    output = r"^    .*\bcore version (\d+)$|^    .*: core (\d+), protocol"
    scores = r"^The scores were measured with core (\d+)"
    return ["".join(found) for found in re.findall(output + "|" + scores, text, re.MULTILINE)]


def main():
    command = "printf 'version 14\\nstate ready\\nlast 3\\n'"
    mark = "text\n<!-- printed by: %s -->\n" % command
    good = mark + "    $ %s\n    version 14\n    state ready\n    last 3\n\nmore" % command
    claim(examined(good) == (good, []), "a block that is what the command prints is left alone")
    stale = good.replace("    version 14\n", "    version 3\n")
    text, differences = examined(stale)
    claim(len(differences) == 1 and text == good, "a block of an older program is found, and renewed")
    cut = mark + "    $ %s\n    version 14\n    ...\n    last 3\n" % command
    claim(examined(cut) == (cut, []), "lines may be left out between those that are shown")
    claim(len(examined(good.replace("    last 3\n", ""))[1]) == 1, "a line that is missing at the end is found")
    claim(
        named_cores(
            "    core version 3\ntext of core version 4\n    a: core 14, protocol 4.0\n"
            "The scores were measured with core 15."
        )
        == ["3", "14", "15"],
        "versions in transcripts and tables are seen",
    )

    found, blocks, cores = [], 0, []
    for name in ["README.md"] + sorted("docs/" + n for n in os.listdir("docs") if n.endswith(".md")):
        with open(name, encoding="utf-8") as file:
            text = file.read()
        blocks += len(list(printed.blocks(text.split("\n"))))
        found += printed.examine(name, os.environ.get("BUILD", "build"))[1]
        cores += ["%s names core %s" % (name, core) for core in named_cores(text) if core != pictures.core_version()]
    claim(
        blocks > 0 and not found,
        "every marked block of the documents is what its command prints",
        "\n".join(found) or "no block",
    )
    claim(not cores, "transcripts and tables of scores name today's core", "\n".join(cores))
    print("1..%d" % count)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
