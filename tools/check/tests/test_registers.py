#!/usr/bin/env python3
"""These tests check the following. The files of the board's port have not changed by a byte since `make
registers` compared them with the chip's description. Prints TAP."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import register_stamp  # noqa: E402
import tree  # noqa: E402


def main():
    report = tree.Report()
    text, now = tree.read(register_stamp.STAMP), register_stamp.digests()
    report.check(
        "%d files of the board's port are those that were held against the chip's description" % len(now),
        register_stamp.differences(text, now),
    )
    changed = dict(now)
    path = sorted(changed)[0]
    changed[path] = "0" * 64
    report.check(
        "a changed file is found",
        [] if list(register_stamp.differences(text, changed)) else ["nothing said of " + path],
    )
    del changed[path]
    report.check(
        "a missing file is found",
        [] if list(register_stamp.differences(text, changed)) else ["nothing said of " + path],
    )
    changed = dict(now, **{register_stamp.PORT + "new.c": "1" * 64})
    report.check(
        "a new file is found", [] if list(register_stamp.differences(text, changed)) else ["nothing said of new.c"]
    )
    report.end()


if __name__ == "__main__":
    main()
