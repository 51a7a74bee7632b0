#!/usr/bin/env python3
"""Simulates scripted scenes with every machine, compiler and optimisation level, and checks that all results have the
same hash. If a hash differs, the script finds the first difference.

  matrix.py [--short] [--jobs 2] [--only TEXT] [--break VARIANT:TICK:PART:NODE] [--programs FOLDER] [--built BUILD]

For each variant, the script builds tools/check/core_hash.c with the simulation core, and runs it natively, in QEMU, or
on an emulated Cortex-M7 board. The script prints a table and also writes this table to out/matrix.tsv. If the results
of a variant differ from those of the first variant, the script finds the first tick, the first part of that tick, and
the first node with a difference. The parts of a tick are feed, stretch, twist, contact, force, solve, angle, friction
and motion. The option --short runs one variant per machine and writes no table. The option --break flips one bit in one
variant, to demonstrate the search. With --programs the built programs are kept in FOLDER, and a later call with the
same FOLDER runs them; otherwise every call builds anew. With --built, the variants of x86-64 and Cortex-M7 contain the
core's objects that ship, from the build folder BUILD, and not objects of their own. The exit code is 0 if all variants
give the same hash, 1 if a hash differs, and 2 for a usage error.
"""

import argparse
import concurrent.futures
import glob
import hashlib
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TABLE = os.path.join("out", "matrix.tsv")
TIME_LIMIT_S = 600
M7_FLAGS = ["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=soft"]
M7_RUN = [
    "qemu-system-arm",
    "-M",
    "mps2-an500",
    "-nographic",
    "-monitor",
    "none",
    "-serial",
    "none",
    "-chardev",
    "stdio,id=console",
]

# Machine -> gcc, clang's target, command that runs a program.
MACHINES = {
    "x86-64": ("gcc", "x86_64-linux-gnu", []),
    "x86-32": ("i686-linux-gnu-gcc", "i686-linux-gnu", []),
    "Cortex-M7": ("arm-none-eabi-gcc", "thumbv7em-none-eabi", M7_RUN),
    "s390x": ("s390x-linux-gnu-gcc", "s390x-linux-gnu", ["qemu-s390x"]),
    "riscv64": ("riscv64-linux-gnu-gcc", "riscv64-linux-gnu", ["qemu-riscv64"]),
}
LEVELS = ("-O2", "-O0", "-O3")
# Machine -> where the build folder has the core's objects that ship (--built).
SHIPPED = {
    "x86-64": "firmware/core/CMakeFiles/crn_firmware_core.dir/**/*.c.o",
    "Cortex-M7": "m7/firmware/images/CMakeFiles/image_core.dir/**/*.c.obj",
}
# Undefined behaviour stops the program; a trap needs no runtime library, so that it works on every machine.
SANITIZER = ["-fsanitize=undefined", "-fsanitize-trap=undefined"]


class Variant:
    def __init__(self, machine, compiler, flags, title):
        self.machine, self.compiler, self.flags = machine, compiler, flags
        self.name = "%s %s %s" % (machine, compiler, title)
        self.objects = []  # of the core, if they are not compiled here (--built)
        self.program = None
        self.problem = None
        self.text = ""
        self.extra = []  # arguments that make the variant differ (--break)

    def hash(self):
        return hashlib.sha256(self.text.encode()).hexdigest()[:16]


def variants(short):
    """The first variant in the list is the reference with which all other variants are compared."""
    found = []
    for machine in MACHINES:
        for compiler in ("gcc", "clang"):
            for level in LEVELS:
                found.append(Variant(machine, compiler, [level], level))
        found.append(Variant(machine, "clang", ["-O1"] + SANITIZER, "-O1 undefined-behaviour traps"))
    if short:
        return [v for v in found if v.compiler == "gcc" and v.flags == ["-O2"]]
    return found


def run(command, time_limit_s=TIME_LIMIT_S):
    """Runs a command and returns (exit code, standard output, standard error), where both outputs are text."""
    done = subprocess.run(
        command,
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        timeout=time_limit_s,
        check=False,
    )
    return done.returncode, done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")


def core_sources():
    return sorted(glob.glob("firmware/core/**/*.c", root_dir=ROOT, recursive=True))


def take_shipped(all_variants, folder):
    """Implements the option --built. Returns a text about objects that are missing, which is empty if none is."""
    names = {os.path.basename(source) for source in core_sources()}
    for variant in all_variants:
        if variant.machine in SHIPPED and variant.compiler == "gcc":
            place = os.path.join(ROOT, folder, SHIPPED[variant.machine])
            variant.objects = sorted(glob.glob(place, recursive=True))
            missing = names - {os.path.basename(path).rsplit(".", 1)[0] for path in variant.objects}
            if missing:
                return "--built: no object of %s in %s; make test builds them" % (", ".join(sorted(missing)), place)
            variant.name = "%s gcc, as it ships" % variant.machine
    return ""


def compile_commands(variant, program):
    """Returns the commands that build the program core_hash. The console file is always compiled, and the program is
    always linked, by the gcc of the target machine."""
    gcc, target, _ = MACHINES[variant.machine]
    bare = variant.machine == "Cortex-M7"
    machine_flags = M7_FLAGS if bare else []
    checked = ["tools/check/core_hash.c", "tools/check/core_scenes.c"]
    if not variant.objects:
        checked += core_sources()
    compiler = [gcc] if variant.compiler == "gcc" else ["clang", "--target=" + target]
    if bare and variant.compiler == "clang":
        compiler.append("-fshort-enums")  # as the ABI of the bare gcc has it
    objects = list(variant.objects)
    for source in checked:
        objects.append("%s.%s.o" % (program, os.path.basename(source)))
        yield (
            compiler
            + machine_flags
            + variant.flags
            + ["-std=c11", "-Wall", "-Wextra", "-Werror", "-ffreestanding", "-I.", "-c", source, "-o", objects[-1]]
        )
    link = [gcc] + machine_flags + ["-std=c11", "-O2", "-I."] + objects
    if bare:
        link += [
            "-ffreestanding",
            "-fno-tree-loop-distribute-patterns",
            "-nostdlib",
            "-Wl,--no-warn-execstack",
            "-T",
            "firmware/port/mps2_an500/image.ld",
            "tools/check/console_semihost.c",
        ]
        link += sorted(glob.glob("firmware/port/mps2_an500/*.c", root_dir=ROOT)) + ["-lgcc"]
    else:
        link += ["-static", "tools/check/console_stdio.c"]
    yield link + ["-o", program]


def build(variant, folder):
    program = os.path.join(folder, variant.name.replace(" ", "_"))
    if os.path.exists(program):
        variant.program = program
        return
    for command in compile_commands(variant, program):
        try:
            code, output, errors = run(command)
        except FileNotFoundError:
            variant.problem = "%s is missing: `make matrix` installs it" % command[0]
            return
        if code != 0:
            variant.problem = "does not build: %s" % (output + errors).strip()
            return
    variant.program = program


def ask(variant, arguments):
    """Runs core_hash with the given arguments and returns its output; raises RuntimeError when the program fails."""
    arguments = arguments + variant.extra
    command = MACHINES[variant.machine][2]
    if variant.machine == "Cortex-M7":
        config = "enable=on,target=native,chardev=console,arg=core_hash" + "".join(",arg=" + a for a in arguments)
        command = command + ["-semihosting-config", config, "-kernel", variant.program]
    else:
        command = command + [variant.program] + arguments
    code, output, errors = run(command)
    if code != 0:
        raise RuntimeError("exit code %d: %s" % (code, (output[-300:] + errors[-300:]).strip()))
    return output


def make(variant, folder):
    """Build and run one variant."""
    build(variant, folder)
    if variant.problem is None:
        try:
            variant.text = ask(variant, [])
        except (RuntimeError, OSError, subprocess.TimeoutExpired) as problem:
            variant.problem = "does not run: %s" % problem
    return variant


def first_difference(expected, got):
    """Returns the index of the first line that differs between two outputs, or None if all lines are equal."""
    for index, (left, right) in enumerate(zip(expected, got)):
        if left != right:
            return index
    return None if len(expected) == len(got) else min(len(expected), len(got))


def locate(reference, variant):
    """Returns a text that describes the first difference from the reference variant, such as 'scene tube, tick 12,
    twist, node 3: 0000000a instead of 0000000b'."""
    expected, got = (ask(v, ["trace"]).splitlines() for v in (reference, variant))
    index = first_difference(expected, got)
    if index is None or not expected[index].startswith("trace ") or not got[index].startswith("trace "):
        return "the traces agree up to their ends: only what a tick returns differs"
    left, right = expected[index].split(), got[index].split()
    scene, tick = left[1], left[2]
    part = next((a for a, b in zip(left[3:], right[3:]) if a != b), "=").split("=")[0]
    question = ["scene", scene, "nodes", tick]
    expected, got = (
        [line for line in ask(v, question).splitlines() if line.split()[3:4] == [part]] for v in (reference, variant)
    )
    index = first_difference(expected, got)
    if index is None:
        return "scene %s, tick %s, %s" % (scene, tick, part)
    left, right = expected[index].split(), got[index].split()
    return "scene %s, tick %s, %s, node %s: %s instead of %s" % (
        scene,
        tick,
        part,
        left[4],
        " ".join(right[5:]),
        " ".join(left[5:]),
    )


def judge(reference, variant):
    """Returns 'equal', or the difference."""
    if variant.problem:
        return variant.problem
    if variant is reference or variant.text == reference.text:
        return "equal"
    if reference.problem:
        return "no reference"
    try:
        return "DIFFERS first at " + locate(reference, variant)
    except RuntimeError as problem:
        return "DIFFERS, and the search failed: %s" % problem


def break_one(all_variants, text):
    """Implements the option --break, which flips a bit in every variant whose name begins with the given text."""
    name, tick, part, node = text.split(":")
    chosen = [v for v in all_variants if v.name.startswith(name)]
    for variant in chosen:
        variant.extra = ["flip", tick, part, node]
    return bool(chosen)


def write_table(rows):
    os.makedirs(os.path.join(ROOT, "out"), exist_ok=True)
    with open(os.path.join(ROOT, TABLE), "w", encoding="utf-8") as file:
        file.writelines("\t".join(row) + "\n" for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="gcc -O2 of every machine only; no table is written")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="variants at a time (default: cores)")
    parser.add_argument("--only", default="", help="only variants whose name holds this text, and the reference")
    parser.add_argument("--programs", metavar="FOLDER", help="build into this folder, and build nothing that is there")
    parser.add_argument("--built", metavar="BUILD", help="with --short: take the objects that ship from this folder")
    parser.add_argument("--break", dest="broken", metavar="VARIANT:TICK:PART:NODE", help="flip a bit in one variant")
    options = parser.parse_args()
    chosen = variants(options.short)
    chosen = chosen[:1] + [v for v in chosen[1:] if options.only in v.name]
    if options.broken and (options.broken.count(":") != 3 or not break_one(chosen[1:], options.broken)):
        parser.error("--break: no variant but the first begins with that name, or not VARIANT:TICK:PART:NODE")
    if options.built and not options.short:
        parser.error("--built: only with --short, whose variants are the ones that ship")
    if options.built and (missing := take_shipped(chosen, options.built)):
        sys.exit(missing)
    with tempfile.TemporaryDirectory() as made:
        folder = options.programs or made
        with concurrent.futures.ThreadPoolExecutor(max(1, options.jobs)) as pool:
            for index, variant in enumerate(pool.map(lambda v: make(v, folder), chosen), 1):
                print("[%d/%d] %s" % (index, len(chosen), variant.name), file=sys.stderr, flush=True)
        rows = [(v.name, "-" if v.problem else v.hash(), judge(chosen[0], v)) for v in chosen]
    for row in rows:
        print("%-44s %-16s  %s" % row)
    if not (options.short or options.only or options.broken):
        write_table([("variant", "hash", "result")] + rows)
        print("written to %s" % TABLE)
    good = sum(row[2] == "equal" for row in rows)
    print("%d of %d variants agree" % (good, len(rows)))
    return 0 if good == len(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
