#!/usr/bin/env python3
"""Tests that later versions of the C library only add to its binary interface. The program libabigail compares the
header with the description (host/library/cournand.abi) in the last tagged version that has one; before there is such a
tag, it compares the header with the committed description.

  test_library_abi.py            prints TAP
  test_library_abi.py --write    writes the description of the present header

The description is made from a small object file that contains only variables. For each function, the object file has
one variable, which is a pointer to a function of this type. For each constant, it has an array of as many bytes as the
constant's value. For each member of a struct, it has one variable of the member's type, and an array of as many bytes
as the member's offset. In the types of functions, structs that begin with struct_bytes are opaque, because later
versions may add members at their end. The size of every other struct must not change. The test of the installed library
checks that this library exports exactly the functions of the header."""

import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
HEADERS = ["host/library/cournand.h", "host/library/cournand_play.h"]
HEADER = HEADERS[0]
KEPT = "host/library/cournand.abi"
failed = 0
number = 0


def report(name, holds, reason=""):
    global failed, number
    number += 1
    failed |= not holds
    print("%sok %d - %s" % ("" if holds else "not ", number, name))
    if not holds:
        print("".join("# %s\n" % line for line in reason.splitlines()), end="")


def run(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, **more)


def structs(text):
    """Returns the members of every struct: {"cournand_pose": ["struct_bytes", ...]}."""
    found = {}
    for body, name in re.findall(r"typedef struct \w+ \{(.*?)\} (\w+);", text, re.S):
        members = []
        for statement in body.split(";"):
            declarators = statement.split(",")
            members += [re.search(r"(\w+)\s*(\[.*)?$", one.strip()).group(1) for one in declarators if one.strip()]
        found[name] = members
    return found


def interface(header):
    """Returns C source code that represents the header's interface by variables."""
    text = re.sub(r"/\*.*?\*/", "", header, flags=re.S)
    members = structs(text)
    grows = [name for name in members if members[name][0] == "struct_bytes"]
    opaque = text
    for name in grows:
        opaque = re.sub(
            r"typedef struct %s \{.*?\} %s;" % (name, name), "typedef struct %s %s;" % (name, name), opaque, flags=re.S
        )
    functions = re.findall(r"COURNAND_API [^;(]*?(cournand_\w+)\(", text)
    calls = ["__typeof__(&%s) type_of_%s;" % (one, one) for one in functions]
    values = ["char value_of_%s[1 + %s];" % (one, one) for one in re.findall(r"^\s*(COURNAND_\w+) = \d+", text, re.M)]
    values += ["char size_of_%s[sizeof(%s)];" % (one, one) for one in members if one not in grows]
    for name, of in members.items():
        for member in of:
            values.append("__typeof__(((%s *)0)->%s) member_%s_%s;" % (name, member, name, member))
            values.append("char offset_%s_%s[1 + offsetof(%s, %s)];" % (name, member, name, member))
    return "\n".join([opaque] + calls), "\n".join([text] + values)


def describe(header, path):
    """Writes the description of the interface that a header's text declares. Returns the compiler's message if the
    header cannot be compiled."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in zip(("calls.c", "values.c"), interface(header)):
            with open(os.path.join(folder, file), "w", encoding="utf-8") as out:
                out.write(text)
        built = run("gcc", "-std=gnu11", "-g", "-shared", "-fPIC", "-o", "i.so", "calls.c", "values.c", cwd=folder)
        if built.returncode != 0:
            return built.stderr
        quiet = ["--no-comp-dir-path", "--no-corpus-path", "--no-show-locs", "--no-elf-needed"]
        made = run("abidw", *quiet, os.path.join(folder, "i.so"), "--out-file", path)
        return made.stderr if made.returncode != 0 else ""


def difference(old, new, more=()):
    """Returns a text that describes what was removed or changed, or "" if nothing was."""
    compared = run("abidiff", *more, old, new)
    return compared.stdout + compared.stderr if compared.returncode != 0 else ""


def minor(header):
    return int(re.search(r"COURNAND_VERSION_MINOR (\d+)", header).group(1))


def check_tag(header, now):
    tag = run("git", "describe", "--tags", "--abbrev=0", "--match", "v*").stdout.strip()
    old = run("git", "show", "%s:%s" % (tag, KEPT)) if tag else None
    if not old or old.returncode != 0:
        found = difference(KEPT, now, ["--no-added-syms"])
        report("nothing of the committed description was removed or changed", not found, found)
        return
    with tempfile.NamedTemporaryFile("w", suffix=".abi") as file:
        file.write(old.stdout)
        file.flush()
        found = difference(file.name, now, ["--no-added-syms"])
        report("nothing of %s was removed or changed: that needs the next major version" % tag, not found, found)
        added = difference(file.name, now)
        is_higher = minor(header) > minor(run("git", "show", "%s:%s" % (tag, HEADER)).stdout)
        report("what was added since %s raised COURNAND_VERSION_MINOR" % tag, is_higher or not added, added)


CHANGES = [
    ("a removed function", False, "COURNAND_API const char *cournand_version_text(void);", ""),
    ("another parameter", False, "cournand_pool_create(uint32_t", "cournand_pool_create(uint64_t"),
    ("a changed constant", False, "COURNAND_LABEL_STENT = 16", "COURNAND_LABEL_STENT = 64"),
    ("another order of members", False, "float heart_phase, breath_phase;", "float breath_phase, heart_phase;"),
    ("another type of a member", False, "float penetration_m;", "int32_t penetration_m;"),
    ("a member in the middle", False, "    uint32_t contact_count;", "    uint32_t contact_count, more;"),
    ("a longer struct without its size", False, "int32_t values[7];", "int32_t values[7], more;"),
    ("a longer struct with its size", True, "uint32_t out_of_range_tick;", "uint32_t out_of_range_tick, more[9];"),
    ("another function", True, "COURNAND_API uint32_t cournand_version(void);",
     "COURNAND_API uint32_t cournand_version(void);\nCOURNAND_API int cournand_new(void);"),
]  # fmt: skip


def main():
    os.chdir(ROOT)
    header = ""
    for name in HEADERS:
        with open(name, encoding="utf-8") as file:
            header += file.read()
    if sys.argv[1:] == ["--write"]:
        said = describe(header, KEPT)
        print(said or "Written: " + KEPT)
        return 1 if said else 0
    with tempfile.TemporaryDirectory() as folder:
        now, new = os.path.join(folder, "now.abi"), os.path.join(folder, "new.abi")
        said = describe(header, now)
        report("the header is described", not said, said)
        with open(now, encoding="utf-8") as made, open(KEPT, encoding="utf-8") as kept:
            is_kept = made.read() == kept.read()
        remedy = "remedy: host/library/tests/test_library_abi.py --write"
        report("the committed description is that of the header", is_kept, remedy)
        check_tag(header, now)
        for name, is_allowed, before, after in CHANGES:
            changed = header.replace(before, after)
            said = describe(changed, new)
            found = difference(now, new, ["--no-added-syms"])
            holds = changed != header and not said and is_allowed == (not found)
            report("%s is %s" % (name, "allowed" if is_allowed else "refused"), holds, said or found)
    print("1..%d" % number)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
