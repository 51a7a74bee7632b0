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


def sources_of(image):
    """Returns the names of the source files whose objects are in an image, from its symbols of the type FILE."""
    text = subprocess.run(["arm-none-eabi-readelf", "-sW", image], stdout=subprocess.PIPE, check=True).stdout
    rows = [line.split() for line in text.decode().splitlines()]
    return {row[7] for row in rows if len(row) == 8 and row[3] == "FILE"}


def usb_findings(sources):
    """The three files of the USB stack that the images for usbtest replace are in an image that ships, and what
    replaces them is not."""
    for name in ("usb_hid.c", "usb_stream.c", "usb_vendor.c"):
        if name not in sources:
            yield "%s is not in the image" % name
    for name in sorted(os.listdir(os.path.join(tree.ROOT, "firmware/app/usb/source_sink"))):
        if name in sources:
            yield "%s is in the image, and only images for usbtest may have it" % name


def main():
    report = tree.Report()
    report.catches("a 64-bit division in an image is caught", linked_sample(DIVIDES))
    for port in PORTS:
        report.check("the image for %s keeps its rules" % port, findings(port))
        sources = sources_of(os.path.join(FOLDER, "cournand-%s.elf" % port))
        report.check("the image for %s has no source and sink for usbtest" % port, usb_findings(sources))
        replaced = sources - {"usb_hid.c"} | {"source_sink.c"}
        report.catches("a source and sink in the image for %s is caught" % port, usb_findings(replaced))
    report.end()


if __name__ == "__main__":
    main()
