#!/usr/bin/env python3
"""The board's port is, byte for byte, the one that `make registers` held against the chip's description. Prints TAP."""

import register_stamp
import tree


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
