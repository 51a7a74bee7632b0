#!/usr/bin/env python3
"""These tests check the following. Builds in two different folders produce the same bytes, and no program
contains the name of the folder in which it was built. The test makes two copies of the source tree in folders
whose paths have different lengths. In each copy the test builds targets of every kind: objects of C and of C++
with debug information, archives, a linked program, and a firmware image with its hex file. The test also searches
all programs of the present build for the name of the repository's folder. Prints TAP.

The copies are built without precompiled headers, which take a minute to make. Only the search for the folder's name
covers programs with precompiled headers. The test compiles the core with -O1, which takes less time than the usual,
higher optimisation level."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "check"))
import tree  # noqa: E402

BUILD = os.environ.get("BUILD", "build")
# Preset, parts and targets of every kind: archives, objects of C and of C++, a linked program, a firmware image and
# its hex file.
BUILDS = (
    ("release", "run,tools", ("crn_shared_scene", "crn_firmware_port_sim", "crn_host_base", "docs")),
    ("m7", "run", ("cournand-imxrt1062",)),
)
COMPARED = re.compile(r"\.(o|obj|a|elf|hex)$|/bin/[a-z]+$")
SAMPLE = "build/host/base/CMakeFiles/crn_host_base.dir/Unity/unity_0_cxx.cxx.o"
SKIPPED = re.compile(r"^(docs/images|hil_tests/.*\.rec|.*\.corpus$|shared/examples/scenes)")


def copy_tree(folder):
    for path in tree.files(""):
        if not SKIPPED.match(path):
            target = os.path.join(folder, path)
            os.makedirs(os.path.dirname(target), exist_ok=True)
            shutil.copy(os.path.join(tree.ROOT, path), target)


def build(folder):
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS", "CCACHE", "BUILD"))}
    environment["CCACHE_DISABLE"] = "1"
    environment["CMAKE_ARGS"] = "-DCRN_PREFIX_HEADERS=OFF -DCRN_DEBUG=-g -DCRN_CORE_OPT=-O1"
    for preset, parts, targets in BUILDS:
        done = subprocess.run(
            ["tools/build.sh", preset, parts, *targets],
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        if done.returncode != 0:
            return [done.stdout.decode("utf-8", "replace")[-2000:]]
    return []


def products(folder):
    found = {}
    for place, _, names in os.walk(os.path.join(folder, "build")):
        for name in names:
            path = os.path.join(place, name)
            if COMPARED.search(path):
                with open(path, "rb") as file:
                    found[os.path.relpath(path, folder)] = file.read()
    return found


def holds(path, words):
    with open(path, "rb") as file:
        return words in file.read()


def check_two_folders(report, work):
    folders = [os.path.join(work, "a"), os.path.join(work, "another", "folder with a longer name".replace(" ", "_"))]
    for folder in folders:
        copy_tree(folder)
        faults = build(folder)
        if faults:
            report.check("the targets are built", faults)
            return
    one, two = products(folders[0]), products(folders[1])
    report.check(
        "both folders have the same files, of every kind",
        [] if one.keys() == two.keys() and len(one) > 60 else ["%d and %d files" % (len(one), len(two))],
    )
    for kind in (r"\.c\.o(bj)?$", r"\.c(pp|xx)\.o$", r"\.a$", r"/bin/", r"\.elf$", r"\.hex$"):
        names = [n for n in one if re.search(kind, n)]
        report.check(
            "two builds in two folders give the same bytes: %d files %s"
            % (len(names), kind.replace("\\", "").strip("$/")),
            ["%s differs" % n for n in names if one[n] != two.get(n)] or ([] if names else ["there are none"]),
        )
    report.check(
        "none of them names its folder", ["%s does" % n for n, data in one.items() if folders[0].encode() in data]
    )
    report.check(
        "debug information is among what is compared",
        [] if b".debug_info" in one[SAMPLE] else ["it is not there"],
    )


def check_programs(report):
    folder = os.path.join(tree.ROOT, BUILD, "bin")
    made = os.path.getmtime(os.path.join(tree.ROOT, "tools", "cmake", "flags.cmake"))
    # Programs with other flags are no evidence for this claim.
    names = (
        [n for n in sorted(os.listdir(folder)) if os.path.getmtime(os.path.join(folder, n)) > made]
        if os.path.isdir(folder)
        else []
    )
    report.check(
        "no program names the folder that it was built in (%d programs)" % len(names),
        [
            "%s names %s: one of its objects was compiled with other flags; make clean, and build it again"
            % (n, tree.ROOT)
            for n in names
            if holds(os.path.join(folder, n), tree.ROOT.encode())
        ],
    )
    with open(os.path.join(tree.ROOT, BUILD, "compile_commands.json"), encoding="utf-8") as file:
        commands = [one["command"] for one in json.load(file)]
    report.check(
        "every compiler gets the option that writes this folder as '.' (%d commands)" % len(commands),
        [one[-200:] for one in commands if "-ffile-prefix-map=%s=." % tree.ROOT not in one]
        or ([] if len(commands) > 200 else ["too few"]),
    )
    timed = [
        p
        for p in tree.files(".c", ".h", ".cpp", ".hpp")
        if re.search(r"__(DATE|TIME|TIMESTAMP)__", tree.code_only(tree.read(p)))
    ]
    report.check("no source asks for the time of the build", timed)


def main():
    report = tree.Report()
    work = tempfile.mkdtemp()
    try:
        check_two_folders(report, work)
    finally:
        shutil.rmtree(work)
    check_programs(report)
    report.end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
