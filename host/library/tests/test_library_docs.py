#!/usr/bin/env python3
"""Tests that the table of functions in docs/library.md has exactly the functions of the two headers. Prints TAP."""

import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "tools", "check"))
import tap  # noqa: E402
import tree  # noqa: E402


def the_page_lists_every_function_of_the_header():
    headers = tree.read("host/library/cournand.h") + tree.read("host/library/cournand_play.h")
    header = re.sub(r"/\*.*?\*/", "", headers, flags=re.S)
    functions = set(re.findall(r"COURNAND_API [^;(]*?(cournand_\w+)\(", header))
    page = tree.read("docs/library.md")
    table = page[page.index("## Functions") : page.index("The test `test_library_docs.py`")]
    listed = re.findall(r"`(cournand_\w+)`", table)
    wrong = sorted(functions.symmetric_difference(listed)) + sorted({one for one in listed if listed.count(one) > 1})
    print("".join("# %s\n" % one for one in wrong), end="")
    return len(functions) >= 40 and not wrong


def the_versions_of_header_and_release_agree():
    header = tree.read("host/library/cournand.h")
    parts = [re.search(r"COURNAND_VERSION_%s (\d+)" % name, header).group(1) for name in ("MAJOR", "MINOR", "PATCH")]
    return 'CRN_VERSION "%s"' % ".".join(parts) in tree.read("shared/version.h")


tap.run([the_page_lists_every_function_of_the_header, the_versions_of_header_and_release_agree])
