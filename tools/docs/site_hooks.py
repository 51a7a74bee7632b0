"""Makes mkdocs show the project's Markdown files in the same way as the website that hosts the repository shows them.

A link to a file outside docs/ (code, NOTICE) becomes the file's path in code font, since the site has no page for such
a file. Python-Markdown recognises a list, a table or an indented block only after an empty line. The project's
documents have lists, tables and blocks directly below a paragraph or a heading, so this module inserts the empty line.
"""

import re

OUTSIDE = re.compile(r"(?<!!)\[([^\]]*)\]\((?:\.\./)+([^)#\s]+)[^)]*\)")
ITEM = re.compile(r"(?:[-*] |\d+\. )")
FENCE = re.compile(r"\s*(```|~~~)")


def paths_as_code(text):
    """Replaces each link to a file outside docs/ with the file's path."""

    def path(match):
        words, target = match.group(1), match.group(2)
        same = words.strip("`").rstrip("/") in (target, target.rstrip("/").rsplit("/", 1)[-1])
        return "`%s`" % target if same else "%s (`%s`)" % (words, target)

    return OUTSIDE.sub(path, text)


def kind_of(line):
    if not line.strip():
        return "empty"
    if line.startswith("#") or line.endswith("-->"):
        return "alone"
    if line.startswith("    "):
        return "indented"
    if ITEM.match(line):
        return "item"
    if line.startswith("|"):
        return "table"
    return "text"


def needs_gap(before, now, in_list):
    """Returns whether Python-Markdown needs an empty line between a line of the kind `before` and a line of the kind
    `now`."""
    if now == "empty" or before in ("empty", now):
        return False
    if now == "item":
        return not in_list
    if now == "indented":
        return before == "alone"
    return now == "table" or before == "table" or before == "alone"


def with_gaps(text):
    kept, before, in_list, in_fence = [], "empty", False, False
    for line in text.split("\n"):
        if FENCE.match(line):
            if not in_fence and before != "empty" and not line.startswith(" "):
                kept.append("")
            in_fence = not in_fence
            kept.append(line)
            before = "alone"
            continue
        if in_fence:
            kept.append(line)
            continue
        now = kind_of(line)
        if needs_gap(before, now, in_list):
            kept.append("")
        in_list = now == "item" or (
            in_list and now not in ("alone", "table") and not (before == "empty" and now == "text")
        )
        kept.append(line)
        before = now
    return "\n".join(kept)


def on_page_markdown(markdown, page, config, files):
    return with_gaps(paths_as_code(markdown))
