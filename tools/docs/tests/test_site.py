#!/usr/bin/env python3
"""Tests the documentation website: every page is in the navigation once, the versions of the Python packages are fixed,
and the functions of site_hooks.py do what their comments state. `make docs` builds it. Prints TAP."""

import collections
import importlib.util
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), ".."))
sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "check"))
import site_hooks  # noqa: E402
import tree  # noqa: E402

PAGE = re.compile(r"^\s+- [^#\n]*?(\S+\.md)\s*$", re.M)
AUDIENCES = ["Home", "Trainee", "Rig builder", "Developer", "Evidence"]


def navigation_faults(config, pages):
    """Returns the pages that are missing from the navigation, and the pages that the navigation lists twice or that do
    not exist."""
    listed = collections.Counter(PAGE.findall(config))
    for page in sorted(set(pages) - set(listed)):
        yield "docs/%s is not in the navigation of mkdocs.yml" % page
    for page, times in sorted(listed.items()):
        if page not in pages:
            yield "mkdocs.yml has %s, which does not exist in docs/" % page
        if times > 1:
            yield "mkdocs.yml has %s %d times" % (page, times)


def unpinned(requirements):
    lines = [line for line in requirements.splitlines() if line and not line.startswith("#")]
    return [line for line in lines if not re.fullmatch(r"[A-Za-z0-9_.-]+==[0-9][\w.]*", line)]


def same(is_, wanted):
    return [] if is_ == wanted else ["is %r, wanted %r" % (is_, wanted)]


def check_navigation(report):
    config = "nav:\n  - Home: index.md\n  - A:\n      - B: b.md\n"
    report.accepts("a navigation with every page is accepted", navigation_faults(config, ["index.md", "b.md"]))
    report.catches("a page that is missing is caught", navigation_faults(config, ["index.md", "b.md", "c.md"]))
    report.catches("so is one that does not exist", navigation_faults(config, ["index.md"]))
    report.catches("and one in two places", navigation_faults(config + "  - C: b.md\n", ["index.md", "b.md"]))
    config = tree.read("mkdocs.yml")
    pages = [path[len("docs/") :] for path in tree.files(".md") if path.startswith("docs/")]
    report.check("every page of docs/ is in the navigation once", navigation_faults(config, pages))
    report.check(
        "the navigation is sorted by audience", same(re.findall(r"^  - ([\w ]+):", config, re.M)[-5:], AUDIENCES)
    )
    report.check(
        "the theme loads no fonts", [] if re.search(r"^  font: false", config, re.M) else ["font is not false"]
    )
    report.catches("a version that is not pinned is caught", unpinned("mkdocs>=1.6\n"))
    report.check("every package of the site is pinned", unpinned(tree.read("tools/docs/requirements.txt")))


def check_hooks(report):
    code = site_hooks.paths_as_code
    report.check("a link to code becomes its path", same(code("see [NOTICE](../NOTICE)."), "see `NOTICE`."))
    report.check(
        "and keeps its words",
        same(code("[the header](../host/a.hpp#b)"), "the header (`host/a.hpp`)"),
    )
    kept = "[a](b.md#c) ![d](../e.jpg) [f](https://g.org/../h)"
    report.check("other links and pictures stay", same(code(kept), kept))
    gaps = site_hooks.with_gaps
    report.check(
        "a list below a paragraph begins behind an empty line", same(gaps("a:\n- b\n  c\n- d"), "a:\n\n- b\n  c\n- d")
    )
    report.check("so does a table", same(gaps("## a\n| b |\n|---|\n| c |\nd"), "## a\n\n| b |\n|---|\n| c |\n\nd"))
    report.check("and code below a heading", same(gaps("# a\n    b\n    c"), "# a\n\n    b\n    c"))
    kept = "a\n\n```\n- b\n| c\n# d\n    e\n```\n\nf\n    g continues\n"
    report.check("fenced code and paragraphs stay", same(gaps(kept), kept))


def check_hosts(report):
    # `site` is also a module of Python, so ours is read by its path.
    spec = importlib.util.spec_from_file_location("docs_site", os.path.join(tree.ROOT, "tools/docs/site.py"))
    docs_site = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(docs_site)
    pattern = docs_site.LOADED
    for bad in (
        '<script src="https://a.org/b.js">',
        "<link rel=stylesheet href=//a.org/b.css>",
        "<style>@import url(https://a.org/c)</style>",
        '<img alt="" src="http://a.org/d.png">',
    ):
        report.check("what a page loads from another host is seen: %s" % bad[1:7], [] if pattern.search(bad) else [bad])
    good = '<a href="https://a.org"> <script src="../a.js"> <link rel="stylesheet" href="site.css">'
    good += ' <link rel="canonical" href="https://a">'
    report.check("links that a reader follows are no such thing", [] if not pattern.search(good) else [good])


def main():
    report = tree.Report()
    check_navigation(report)
    check_hooks(report)
    check_hosts(report)
    report.end()


if __name__ == "__main__":
    main()
