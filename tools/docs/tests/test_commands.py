#!/usr/bin/env python3
"""These tests check the following. The program commands.py finds the commands in the documents and obeys the markers
(HTML comments) above them. The test also runs those commands of the documents that take only seconds
(tools/docs/commands.py); `make test-lab` also runs the slower ones. Prints TAP."""

import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), ".."))
sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "check"))
import command_blocks  # noqa: E402
import commands  # noqa: E402
import tree  # noqa: E402

PAGE = """# Title
    make all      # directly below a heading
    build/bin/bake a.toml \\
        -o b.scene
A paragraph that names a program
    build/bin/bake in an indented line of its own is none.

    EI = 3 m, which is no command

<!-- command: lab; only --slow -->
<!-- command: short; exit 3; with MY=shared/my
     HIS=out/his; adding --size 64 -->
    build/bin/cournand run MY HIS/x  # why
    build/bin/cournand run --slow

```toml
make = "no command"
```

```
$ cournand info a.rec
make says this
```
"""
WANTED = [
    (2, "make", 0, "make all      # directly below a heading"),
    (3, "short", 0, "build/bin/bake a.toml -o b.scene"),
    (13, "short", 3, "build/bin/cournand run MY HIS/x  # why"),
    (14, "lab", 0, "build/bin/cournand run --slow"),
    (21, "short", 0, "cournand info a.rec"),
]
BLOCK = "    build/bin/bake\n"


def same(is_, wanted):
    return [] if is_ == wanted else ["is %r, wanted %r" % (is_, wanted)]


def refused(text):
    """Returns the message about a page whose marker is wrong; empty when the marker is accepted."""
    try:
        command_blocks.commands("a.md", text)
    except command_blocks.MarkError as error:
        return [str(error)]
    return []


def check_extraction(report):
    found = command_blocks.commands("a.md", PAGE)
    report.check(
        "commands are found with line, class, exit code and continuation",
        same([(c.line, c.kind, c.exit, c.text) for c in found], WANTED),
    )
    report.check(
        "names are replaced and words added",
        same(commands.prepared(found[2]), "build/bin/cournand run shared/my out/his/x --size 64"),
    )
    report.catches("a class that does not exist is refused", refused("<!-- command: later -->\n" + BLOCK))
    report.catches("so is a marker with an unknown part", refused("<!-- command: lab; when idle -->\n" + BLOCK))
    report.catches("one above no command", refused("<!-- command: lab -->\ntext\n"))
    report.catches("and one that fits none of the block", refused("<!-- command: lab; only x9 -->\n" + BLOCK))
    report.accepts("a marker above its block is taken", refused("<!-- command: lab -->\n" + BLOCK))
    report.check(
        "a block of output has no commands",
        same(command_blocks.commands("a.md", "<!-- command: output -->\n    cournand on a\n"), []),
    )
    reasons = [kind for kind, (runs, why) in command_blocks.CLASSES.items() if len(runs) < 2 and not why]
    report.check("every class that is not run has a reason", reasons)


def check_looks(report):
    targets = {"test"}
    report.catches(
        "a make target in a sentence that does not exist is caught",
        commands.inline_faults("a.md", "see `make A=1 tset`", targets),
    )
    report.accepts(
        "other spans are no such thing",
        commands.inline_faults("a.md", "`a` make b `c`, `make test`, `make build/x`", targets),
    )
    report.catches("a target that does not exist fails its dry run", commands.make_faults("make no-such-target"))
    report.catches("an option that does not exist is caught", commands.option_faults(["--wrong"], "--wronger --size"))
    report.accepts("and one that does is not", commands.option_faults(["--size=3"], "  --size UINT"))


def check_documents(report):
    words = [os.path.join(tree.ROOT, "tools/docs/commands.py")] + sys.argv[1:]
    done = subprocess.run(
        words, cwd=tree.ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    results, finding = [], []
    for line in done.stdout.splitlines():
        result = re.match(r"(not ok|ok) \d+ - (.*)", line)
        if result:
            finding = []
            results.append((result.group(2), result.group(1), finding))
        elif line.startswith("#- "):
            print(line)
        elif not line.startswith("1.."):
            finding.append(line)
    for name, state, why in results:
        report.check(name, (why or ["failed"]) if state == "not ok" else [])
    report.check(
        "all commands of README and docs were judged",
        [] if results and done.returncode in (0, 1) else [done.stdout[-600:]],
    )


def main():
    report = tree.Report()
    check_extraction(report)
    check_looks(report)
    check_documents(report)
    report.end()


if __name__ == "__main__":
    main()
