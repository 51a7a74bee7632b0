"""Stores digests of those files of the board's port that were compared with the chip's description; check_registers.py
writes the digests."""

import hashlib
import os

import tree

PORT = "firmware/port/imxrt1062/"
STAMP = PORT + "registers.checked"


def digests():
    """Returns a table that maps the path of every C file and header of the port to its SHA-256."""
    return {
        path: hashlib.sha256(tree.read(path).encode()).hexdigest()
        for path in tree.files(".c", ".h")
        if path.startswith(PORT)
    }


def write(description):
    lines = ["# Held against %s by `make registers`; any change of these files needs it anew.\n" % description]
    lines += ["%s  %s\n" % (digest, path) for path, digest in sorted(digests().items())]
    with open(os.path.join(tree.ROOT, STAMP), "w", encoding="ascii") as file:
        file.writelines(lines)


def differences(text, now):
    """Returns the differences between the digests in the stamp file and those of the present files."""
    said = dict(reversed(line.split("  ", 1)) for line in text.splitlines() if line and not line.startswith("#"))
    for path in sorted(set(said) | set(now)):
        if path not in said:
            yield path + ": never held against the chip's description: make registers"
        elif path not in now:
            yield path + ": is gone: make registers"
        elif said[path] != now[path]:
            yield path + ": changed since it was held against the chip's description: make registers"
