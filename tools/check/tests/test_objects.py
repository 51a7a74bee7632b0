#!/usr/bin/env python3
"""Checks with nm that the compiled core has no library calls, no floating point, no divide helper and no global state.
This test also checks that every generated file equals the present output of its generator. Prints TAP.

The test reads the objects that ship, which the build has made: those of the host for 64-bit x86, and those of the
images for Cortex-M7. For 32-bit x86, the test compiles the core into a temporary folder (clang, -O2). The test needs
the 32-bit machines because they call a helper function for a 64-bit division; a 64-bit machine has an instruction for
it."""

import glob
import os
import re
import subprocess
import tempfile

import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

FLAGS = ["-std=c11", "-I.", "-ffreestanding", "-Wall", "-Wextra", "-Werror", "-c"]
TARGETS = {
    "x86-64": ["gcc", "-O3"],
    "x86-32": ["clang", "--target=i686-linux-gnu", "-O2"],
    "Cortex-M7": ["clang", "--target=thumbv7em-none-eabihf", "-mcpu=cortex-m7", "-O2"],
}
BUILD = os.environ.get("CRN_SHIPPED") or os.environ.get("BUILD", "build")
BUILT = {
    "x86-64": "firmware/core/CMakeFiles/crn_firmware_core.dir",
    "Cortex-M7": "m7/firmware/images/CMakeFiles/image_core.dir",
}
# Functions that a freestanding compiler may call: the four memory functions, in plain and ARM spelling.
MEMORY = re.compile(r"^(__aeabi_)?mem(cpy|set|move|cmp|clr)(4|8)?$")
HARMLESS = {"_GLOBAL_OFFSET_TABLE_"}


def compile_to(folder, command, sources):
    """Compile sources; returns (objects, findings)."""
    objects, findings = [], []
    for source in sources:
        target = os.path.join(folder, source.replace("/", "_") + ".o")
        done = subprocess.run(
            command + FLAGS + [source, "-o", target],
            cwd=tree.ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        if done.returncode == 0:
            objects.append(target)
        else:
            findings.append("%s does not compile: %s" % (source, done.stdout.decode("utf-8", "replace")))
    return objects, findings


def built(folder, sources):
    """Returns the objects that the build has made from the sources, and a finding for each source without one."""
    places = glob.glob(os.path.join(tree.ROOT, BUILD, folder, "**", "*.o*"), recursive=True)
    by_name = {re.sub(r"\.o(bj)?$", "", os.path.basename(place)): place for place in places}
    names = [os.path.basename(source) for source in sources]
    objects = [by_name[name] for name in names if name in by_name]
    return objects, ["no object of %s below %s/%s" % (name, BUILD, folder) for name in names if name not in by_name]


def symbols(objects):
    """Yields (object file, letter of nm, name) of every symbol in the object files."""
    for path in objects:
        text = subprocess.run(["nm", path], check=True, stdout=subprocess.PIPE).stdout.decode()
        for line in text.splitlines():
            fields = line.split()
            if len(fields) >= 2:
                yield os.path.basename(path), fields[-2], fields[-1]


def foreign_calls(objects):
    found = list(symbols(objects))
    own = {name for _, letter, name in found if letter in "TRtrBbDdCV"}
    for path, letter, name in found:
        if letter == "U" and name not in own and name not in HARMLESS and not MEMORY.match(name):
            yield "%s calls %s: the core is freestanding (a divide or float helper, libm or libc)" % (path, name)


def global_state(objects):
    for path, letter, name in symbols(objects):
        if letter in "BbDdCSs":
            yield "%s: %s is writable global data: keep it in crn_state" % (path, name)


def check_sample(report, name, text, rule, command):
    with tempfile.TemporaryDirectory() as folder:
        source = os.path.join(folder, "sample.c")
        with open(source, "w", encoding="ascii") as file:
            file.write(text)
        objects, findings = compile_to(folder, command, [source])
        report.catches(name, list(rule(objects)) if not findings else [])


def self_test(report):
    head = "#include <stdint.h>\n"
    check_sample(
        report,
        "a 64-bit division is caught on x86-32",
        head + "uint64_t f(uint64_t a, uint64_t b) { return a / b; }\n",
        foreign_calls,
        TARGETS["x86-32"],
    )
    check_sample(
        report,
        "a 64-bit division is caught on Cortex-M7",
        head + "int64_t f(int64_t a, int64_t b) { return a / b; }\n",
        foreign_calls,
        TARGETS["Cortex-M7"],
    )
    check_sample(
        report,
        "soft double arithmetic is caught on Cortex-M7",
        "double f(double a) { return a * 3.0; }\n",
        foreign_calls,
        TARGETS["Cortex-M7"][:2] + ["-mfloat-abi=soft", "-O2"],
    )
    check_sample(
        report,
        "a call of libm is caught",
        "extern int sqrtf_like(int);\nint f(int a) { return sqrtf_like(a); }\n",
        foreign_calls,
        TARGETS["x86-64"],
    )
    check_sample(
        report,
        "writable global data is caught",
        "static int count;\nint f(void) { return ++count; }\n",
        global_state,
        TARGETS["x86-64"],
    )


def stale(script):
    done = subprocess.run(
        [os.path.join(tree.ROOT, script), "--check"],
        cwd=tree.ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if done.returncode != 0:
        yield done.stdout.decode("utf-8", "replace").strip()


def main():
    report = tree.Report()
    self_test(report)
    folders = ("firmware/core", "firmware/core/near", "firmware/core/wall")
    sources = [path for path in tree.files(".c") if os.path.dirname(path) in folders]
    report.check("there is a core to check", [] if sources else ["no .c file in firmware/core"])
    for name, command in TARGETS.items():
        with tempfile.TemporaryDirectory() as folder:
            found = built(BUILT[name], sources) if name in BUILT else compile_to(folder, command, sources)
            objects, findings = found
            report.check("the core compiles freestanding for " + name, findings)
            report.check("the core calls nothing but itself and memcpy on " + name, foreign_calls(objects))
            report.check("the core has no writable global data on " + name, global_state(objects))
    report.check(
        "the tables of the core are what tools/check/make_tables.py writes", stale("tools/check/make_tables.py")
    )
    report.end()


if __name__ == "__main__":
    main()
