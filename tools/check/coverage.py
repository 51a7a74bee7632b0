#!/usr/bin/env python3
"""Counts the project's source lines that a run of the tests executes, for each folder and in total.

  coverage.py --build build/coverage --profiles build/coverage/profiles --programs FILE...

The test programs must be compiled by clang with `-fprofile-instr-generate -fcoverage-mapping`, and must have run with
LLVM_PROFILE_FILE=build/coverage/profiles/%p-%m.profraw. The script counts no lines of tests, of generated files below
the build folder, or of third-party headers. The script writes its figures to out/coverage.tsv, as lines
`name<TAB>value<TAB>unit<TAB>context`.
"""

import argparse
import collections
import json
import os
import shutil
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
VERSION = 14  # clang of Debian 12; a profile of another clang is refused by name


class CoverageError(Exception):
    """An error with its remedy."""


def tool(name):
    for candidate in ("%s-%d" % (name, VERSION), name):
        if shutil.which(candidate):
            return candidate
    raise CoverageError("no %s-%d. Remedy: sudo apt-get install llvm-%d" % (name, VERSION, VERSION))


def call(words):
    done = subprocess.run(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace", check=False
    )
    if done.returncode != 0:
        raise CoverageError("%s ended with %d: %s" % (words[0], done.returncode, done.stderr.strip()[-800:]))
    return done.stdout


def profiles_in(folder):
    """Returns every .profraw file (raw coverage profile) below a folder, except empty files, which a killed program may
    leave."""
    found = []
    for parent, _, names in os.walk(folder):
        found += [os.path.join(parent, name) for name in names if name.endswith(".profraw")]
    found = sorted(path for path in found if os.path.getsize(path) > 0)
    if not found:
        raise CoverageError(
            "no .profraw below %s. Remedy: run the tests with LLVM_PROFILE_FILE=%s/%%p-%%m.profraw" % (folder, folder)
        )
    return found


def merged(build, profiles):
    """Merges the coverage profiles of all program runs into one profile."""
    listed, whole = os.path.join(build, "profiles.txt"), os.path.join(build, "coverage.profdata")
    with open(listed, "w", encoding="utf-8") as file:
        file.write("".join("%s\n" % path for path in profiles))
    call([tool("llvm-profdata"), "merge", "-sparse", "-failure-mode=all", "-f", listed, "-o", whole])
    return whole


def exported(profile, programs):
    """Returns the summary that llvm-cov computes for every source file."""
    for path in programs:
        if not os.path.isfile(path):
            raise CoverageError("no program %s: did it build?" % path)
    words = [tool("llvm-cov"), "export", "-summary-only", "-instr-profile=" + profile, programs[0]]
    for path in programs[1:]:
        words += ["-object", path]
    return json.loads(call(words))["data"][0]["files"]


def counted_path(path, root, build):
    """Returns a file's path inside the repository, or None if the lines of this file are not counted."""
    # The compiler replaces the repository's path by ".", and puts the build folder before it: "build/./host/x.cpp".
    path = path.rpartition("/./")[2]
    inside = os.path.relpath(os.path.join(root, path), root)
    parts = inside.split(os.sep)
    if (
        parts[0] == ".."
        or "tests" in parts
        or inside.startswith(os.path.relpath(os.path.join(root, build), root) + os.sep)
    ):
        return None
    return None if parts[0] in ("build", "hil_tests") else inside


def by_folder(files, root, build):
    """Returns a sorted table from folder to [executed lines, all lines]."""
    folders = collections.defaultdict(lambda: [0, 0])
    for file in files:
        path = counted_path(file["filename"], root, build)
        if path:
            lines = file["summary"]["lines"]
            folders[os.path.dirname(path) or "."][0] += lines["covered"]
            folders[os.path.dirname(path) or "."][1] += lines["count"]
    return dict(sorted(folders.items()))


def percent(run, lines):
    return 100.0 * run / lines if lines else 0.0


def rows(folders):
    total = [sum(one[at] for one in folders.values()) for at in (0, 1)]
    yield "coverage.lines", total, "folders=%d" % len(folders)
    for folder, counts in folders.items():
        yield "coverage.lines." + folder, counts, ""


def report(folders, tsv):
    os.makedirs(os.path.dirname(tsv) or ".", exist_ok=True)
    with open(tsv, "w", encoding="utf-8") as file:
        for name, (run, lines), more in rows(folders):
            context = "run=%d lines=%d %s" % (run, lines, more)
            file.write("%s\t%.1f\t%%\t%s\n" % (name, percent(run, lines), context.strip()))
    width = max([len(folder) for folder in folders] + [5])
    print("%-*s %8s %8s %7s" % (width, "folder", "run", "lines", "%"))
    for name, (run, lines), _ in list(rows(folders))[1:] + list(rows(folders))[:1]:
        title = name.replace("coverage.lines", "", 1).lstrip(".") or "total"
        print("%-*s %8d %8d %7.1f" % (width, title, run, lines, percent(run, lines)))
    print("Written: %s" % tsv)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True, help="build folder of the programs; the merged profile goes there")
    parser.add_argument("--profiles", required=True, help="folder of the .profraw files")
    parser.add_argument("--programs", nargs="+", required=True, metavar="FILE", help="the programs that ran")
    parser.add_argument("--tsv", default="out/coverage.tsv", help="where the figures go (default: out/coverage.tsv)")
    parser.add_argument("--root", default=ROOT, help="folder of the sources (default: this repository)")
    options = parser.parse_args()
    try:
        profile = merged(options.build, profiles_in(options.profiles))
        folders = by_folder(exported(profile, options.programs), options.root, options.build)
        if not folders:
            raise CoverageError("no line of %s is in these programs" % options.root)
    except CoverageError as error:
        print("coverage: %s" % error, file=sys.stderr)
        return 1
    report(folders, options.tsv)
    return 0


if __name__ == "__main__":
    sys.exit(main())
