#!/usr/bin/env python3
"""Copies the values of firmware/bench/budget.tsv into three pages, between two marks on each: the column "now" of
docs/bench.md, the priced ticks of docs/budget.md, and the table of boards of docs/porting.md.

  budget_docs.py [--write]

Without --write this program only compares the pages with the budget, and its exit code is 1 when they differ.
"""

import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools", "bench"))
import budget  # noqa: E402
import chip_budget  # noqa: E402

BEGIN, END = "<!-- begin: written by `make budget-docs` -->\n", "<!-- end -->\n"
# Names in the budget and on the pages; a tick may take 90 % of a millisecond, because the app needs the rest.
BOARDS = (("rt1062", "i.MX RT1062"), ("rt1176", "i.MX RT1176"), ("stm32h735", "STM32H735"))
FITS_permille = 900
COUNTS = {1: "one tool", 2: "two tools", 3: "three tools", 4: "four tools in turn"}
PLACES = {
    "aorta": "the still aorta",
    "heart": "the beating heart",
    "renal_pci": "the still renal artery with a stenosis",
    "lad_pci": "the beating LAD with a stenosis",
}
MEAN, WORST = "rod.m7_instructions", "rod.m7_instructions_worst"
# case, row of the budget, first version with three tools, goal
ROWS = (
    ("100 contacts (122 in the case)", MEAN, "elements=256 contacts=100+", "1,298 k", "400 k"),
    ("all in contact", MEAN, "elements=256 contacts=all", "1,388 k", "470 k"),
    ("three tools sliding, all in contact", MEAN, "elements=256 contacts=all tools=3 sliding", "1,696 k", ""),
    ("128 elements", MEAN, "elements=128 contacts=20+", "497 k", "190 k"),
    ("worst tick that missed a contact", WORST, "elements=256 second_solve", "1,874 k", "800 k"),
)


def table(rows):
    lines = [
        "| Cortex-M7, 256 elements where not said otherwise | first version with three tools | now | goal |\n",
        "|---|---|---|---|\n",
    ]
    for case, name, context, first, goal in ROWS:
        lines.append("| %s | %s | {:,} k | %s |\n".format(round(rows[name, context] / 1000)) % (case, first, goal))
    return "".join(lines)


def key_of(context):
    return tuple(word for word in context.split() if not word.startswith(("board=", "p99.9")))


def chip_cases(rows):
    """Yields the name of each priced case and its values by row name, or by board for the shares."""
    cases = {}
    for (name, context), value in rows.items():
        board = [word[len("board=") :] for word in context.split() if word.startswith("board=")]
        if name.startswith("chip.") and name != "chip.scene_bytes":
            cases.setdefault(key_of(context), {})[board[0] if board else name] = value
    return cases.items()


def title_of(key):
    return " ".join(key).replace("found ", "found: ").replace("session=", "session ").replace("_", "\\_")


def thousands(value):
    return "{:,} k".format(round(value / 1000))


def chip_table(rows):
    lines = [
        "| tick | instructions | cycles without misses | misses: scene, near | lines, bricks | %s |\n"
        % " | ".join(name for _, name in BOARDS),
        "|---|---|---|---|---|%s\n" % ("---|" * len(BOARDS)),
    ]
    for key, values in chip_cases(rows):
        shares = " | ".join("%.0f %%" % (values[board] / 10) for board, _ in BOARDS)
        lines.append(
            "| %s | %s | %s | {:,}, {:,} | {:,}, {:,} | %s |\n".format(
                values["chip.misses"], values["chip.near_misses"], values["chip.lines"], values["chip.bricks"]
            )
            % (title_of(key), thousands(values["chip.instructions"]), thousands(values["chip.pipeline_cycles"]), shares)
        )
    return "".join(lines)


def verdict(permille):
    return "yes" if permille <= FITS_permille else "only just" if permille <= 1000 else "no"


def claim_of(key):
    """The words of a claim for a session or a found tick."""
    values = dict(word.split("=", 1) for word in key if "=" in word)
    if "session" in values:
        scene = next(scene for name, scene, _ in chip_budget.SESSIONS if name == values["session"])
        stent = " and a stent" if "stent" in key else ""
        tools = COUNTS[int(values["tools"])]
        return "%s in %s%s, as in the session `%s`" % (tools, PLACES[scene], stent, values["session"])
    tools = values["tools"].split(",")
    return "%s in %s, whatever the hands do" % (COUNTS[len(tools)], PLACES[values["scene"]])


def board_table(rows):
    """What each board can do, in the words of a claim: from the sessions and from the dearest ticks that were found."""
    lines = [
        "| claim | %s |\n" % " | ".join(name for _, name in BOARDS),
        "|---|%s\n" % ("---|" * len(BOARDS)),
    ]
    for key, values in chip_cases(rows):
        if not key[0].startswith(("session=", "found")):
            continue
        cells = ["%s (%.0f %%)" % (verdict(values[board]), values[board] / 10) for board, _ in BOARDS]
        lines.append("| %s | %s |\n" % (claim_of(key), " | ".join(cells)))
    return "".join(lines)


PAGES = (("bench.md", table), ("budget.md", chip_table), ("porting.md", board_table))


def renewed(text, rows, page="bench.md", make=table):
    """Returns the text of a page after replacing the block between the two marks."""
    before, mark, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not mark or not end:
        raise SystemExit("budget_docs: docs/%s has no block between '%s' and '%s'" % (page, BEGIN.strip(), END.strip()))
    return before + BEGIN + make(rows) + END + after


def main():
    rows, different = budget.read_budget(), 0
    for page, make in PAGES:
        path = os.path.join(ROOT, "docs", page)
        with open(path, encoding="utf-8") as file:
            text = file.read()
        new = renewed(text, rows, page, make)
        if sys.argv[1:] == ["--write"]:
            with open(path, "w", encoding="utf-8") as file:
                file.write(new)
        elif new != text:
            print(
                "docs/%s is not what firmware/bench/budget.tsv says: `make budget-docs` writes it anew" % page,
                file=sys.stderr,
            )
            different = 1
    return different


if __name__ == "__main__":
    sys.exit(main())
