#!/usr/bin/env python3
"""Checks the firmware images that `make test` built. The images must contain no soft-float code, no divide helper and
no heap, and their RAM and stack must be within the limits. `make firmware` applies the same rules to a firmware image
and also prints the sizes of its code, RAM and stack. BUILD is the build folder. Prints TAP."""

import contextlib
import io
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

sys.path.insert(0, os.path.join(tree.ROOT, "tools", "bench"))
import budget  # noqa: E402
import image_report  # noqa: E402

BUILD = os.path.join(tree.ROOT, os.environ.get("BUILD", "build"))
FOLDER = os.path.join(BUILD, "firmware")
PORTS = ("mps2_an500", "imxrt1062")
DIVIDES = (
    "long long f(long long a, long long b) { return a / b; }\n"
    "void _start(void) { volatile long long x = 9; x = f(x, x); }\n"
)


def linked_sample(text):
    """Compiles and links C source for the Cortex-M7, and returns the forbidden function names in the result."""
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "sample.elf")
        subprocess.run(
            [
                "arm-none-eabi-gcc",
                "-mcpu=cortex-m7",
                "-mthumb",
                "-O2",
                "-ffreestanding",
                "-nostdlib",
                "-x",
                "c",
                "-",
                "-o",
                image,
                "-lgcc",
            ],
            input=text.encode(),
            check=True,
        )
        return budget.forbidden_symbols(image)


def findings(port):
    image = os.path.join(FOLDER, "cournand-%s.elf" % port)
    figures = io.StringIO()
    try:
        with contextlib.redirect_stdout(figures):
            yield from image_report.report(image, budget.image_objects(BUILD, port), port)
    except budget.CannotMeasure as problem:
        yield str(problem)
    for line in figures.getvalue().splitlines()[1:]:
        print("#- %s: %s" % (port, line.strip()))


def main():
    report = tree.Report()
    report.catches("a 64-bit division in an image is caught", linked_sample(DIVIDES))
    for port in PORTS:
        report.check("the image for %s keeps its rules" % port, findings(port))
    report.end()


if __name__ == "__main__":
    main()
