#!/usr/bin/env python3
"""These tests check the following. The program coverage.py counts, for each folder, the lines that at least one of two
programs executes. The program prints an error if its input is missing. Prints TAP."""

import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(__file__), ".."))
import tree  # noqa: E402

SOURCES = {
    "core/sum.c": "int sum(int a, int b)\n{\n    return a + b;\n}\n"
    "int never(int a)\n{\n    a += 1;\n    return a;\n}\n",
    "app/one.c": "int sum(int a, int b);\nint main(void)\n{\n    return sum(1, -1);\n}\n",
    "app/tests/test_two.c": "int never(int a);\nint main(void)\n{\n    return never(-1);\n}\n",
}
FLAGS = ["-fprofile-instr-generate", "-fcoverage-mapping", "-O0"]


def make(root):
    for path, text in SOURCES.items():
        os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
        with open(os.path.join(root, path), "w", encoding="ascii") as file:
            file.write(text)
    os.makedirs(os.path.join(root, "build/profiles"))
    for program, source in (("one", "app/one.c"), ("two", "app/tests/test_two.c")):
        # CMake compiles in the build folder, with the whole path of each source.
        words = ["clang"] + FLAGS + ["-ffile-prefix-map=%s=." % root]
        words += [os.path.join(root, path) for path in (source, "core/sum.c")] + ["-o", program]
        subprocess.run(words, cwd=os.path.join(root, "build"), check=True)


def run(root, program):
    environment = dict(os.environ, LLVM_PROFILE_FILE=os.path.join(root, "build/profiles/%p-%m.profraw"))
    subprocess.run([os.path.join(root, "build", program)], env=environment, check=True)


def coverage(root, *programs):
    """Runs coverage.py and returns its exit code, its figures by name, and its printed text."""
    words = [os.path.join(tree.ROOT, "tools/check/coverage.py"), "--root", root, "--tsv", "out/coverage.tsv"]
    words += ["--build", "build", "--profiles", "build/profiles", "--programs"] + ["build/" + name for name in programs]
    done = subprocess.run(words, cwd=root, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    figures = {}
    if done.returncode == 0:
        with open(os.path.join(root, "out/coverage.tsv"), encoding="ascii") as file:
            figures = {line.split("\t")[0]: line.rstrip("\n").split("\t")[1:] for line in file}
    return done.returncode, figures, done.stdout


def main():
    report = tree.Report()
    with tempfile.TemporaryDirectory() as root:
        make(root)
        code, _, said = coverage(root, "one")
        report.check(
            "without a profile it says how to get one", [] if code == 1 and "LLVM_PROFILE_FILE" in said else [said]
        )
        run(root, "one")
        code, figures, said = coverage(root, "one")
        wanted = ["42.9", "%", "run=3 lines=7"]  # from brace to brace: sum() has three lines, never() four
        core = figures.get("coverage.lines.core", [said])
        report.check("lines of a folder that ran are counted", [] if core == wanted else core)
        run(root, "two")
        code, figures, said = coverage(root, "one", "two")
        core = figures.get("coverage.lines.core", [said])
        report.check("those of another program are added", [] if core == ["100.0", "%", "run=7 lines=7"] else core)
        report.check(
            "tests are not counted, and the total is that of the folders",
            []
            if sorted(figures) == ["coverage.lines", "coverage.lines.app", "coverage.lines.core"]
            and figures["coverage.lines"] == ["100.0", "%", "run=10 lines=10 folders=2"]
            else [str(figures)],
        )
        code, _, said = coverage(root, "three")
        report.check("a program that did not build is named", [] if code == 1 and "build/three" in said else [said])
    report.end()


if __name__ == "__main__":
    sys.exit(main())
