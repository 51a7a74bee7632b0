#!/usr/bin/env python3
"""Measures the instructions, stack and memory of the core's tick on a Cortex-M7, and compares them with
firmware/bench/budget.tsv (docs/bench.md).

  budget.py --build build [--accept] [--search] [--jobs N] [--profile CASE]

QEMU with -icount shift=0 counts each instruction as one nanosecond. The stack of a tick is the largest sum of stack
bytes along a path through the compiler's call graph. The sizes of code and data come from the object files. The exit
code is 1 when a measured value is more than 3 % above its row in budget.tsv, when budget.tsv lacks a row, or when the
image calls a forbidden helper function. Soft-float helpers, divide helpers and heap functions are forbidden. The option
--accept writes the measured values into budget.tsv. The program prices the same cases, sessions that ship, and ticks
that a search found in cycles of three boards (chip_budget.py, docs/budget.md); the option --search only searches for
such ticks anew. The option --profile only prints, for each function, how many
instructions two ticks of a case execute.
"""

import argparse
import bisect
import collections
import glob
import os
import re
import subprocess
import sys
import tempfile

import chip_budget

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BUDGET = os.path.join("firmware", "bench", "budget.tsv")
OVER = 1.03
TIME_LIMIT_S = 600
QEMU = [
    "qemu-system-arm",
    "-M",
    "mps2-an500",
    "-nographic",
    "-monitor",
    "none",
    "-serial",
    "none",
    "-icount",
    "shift=0",
]
# The worst stack of these entry points is reported.
ROOTS = ("crn_step", "crn_state_restore", "crn_model_build")
MEMORY = re.compile(r"^(__aeabi_)?mem(cpy|set|move|cmp|clr)(4|8)?$")
FORBIDDEN = re.compile(
    r"^(__aeabi_([dfil]|u?[il]div|ul|uldiv).*|__.*(div|mod)[sdt]i\d|"
    r"__(add|sub|mul|div|fix|float|cmp|eq|lt|gt)\w*[sd]f\w*|"
    r"malloc|calloc|realloc|free|_sbrk)$"
)
ALLOWED_HELPERS = re.compile(r"^__aeabi_l(lsl|lsr|asr|mul)$")  # 64-bit shifts and products: a few instructions, no loop
HASHED_CASE = "elements=256 contacts=all"
INSTRUCTIONS_PER_COUNT = 40  # of SysTick: firmware/port/mps2_an500/systick.h
DIVISION = re.compile(r"^__aeabi_u?ldivmod$")  # forbidden, but its stack is known: the caller reports the name
DIVISION_BYTES = 64
LOOP_MIN = 12  # shorter loops are not worth an estimate


class CannotMeasure(Exception):
    """Raised when a value cannot be measured; the text gives the reason."""


def run(command, text=None, check=True):
    try:
        done = subprocess.run(
            command,
            cwd=ROOT,
            input=text,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            check=False,
            timeout=TIME_LIMIT_S,
            universal_newlines=True,
        )
    except FileNotFoundError as error:
        raise CannotMeasure("%s is missing: `make budget` installs it" % command[0]) from error
    if check and done.returncode != 0:
        raise CannotMeasure(
            "%s: exit code %d: %s" % (" ".join(command), done.returncode, (done.stdout + done.stderr).strip()[-400:])
        )
    return done.stdout


# --- instructions ---------------------------------------------------------------------------------------------------
def emulate(image, case_file):
    """Runs the benchmark image in QEMU and returns its output as a table of numbers."""
    text = run(
        QEMU
        + [
            "-chardev",
            "stdio,id=console",
            "-semihosting-config",
            "enable=on,target=native,chardev=console,arg=budget_image,arg=" + case_file,
            "-kernel",
            image,
        ]
    )
    return {line.split()[0]: int(line.split()[1]) for line in text.splitlines()}


def case_path(folder, number):
    return os.path.join(folder, "case%d" % number)


def measure_case(make, image, number, context, folder):
    """Measures one benchmark case and yields its rows of the budget."""
    path = case_path(folder, number)
    words = run([make, "make", str(number), path]).split()
    counted = emulate(image, path)
    if words[:1] == ["second_solves"]:
        context = "%s contacts=%s (%s of %s driven ticks)" % (context, words[5], words[1], words[3])
        yield "rod.m7_instructions_worst", counted["most_twice"], "instructions", context
    elif "inserting" in context:
        yield "rod.m7_instructions_worst", counted["most"], "instructions", context
    else:
        mean = counted["counts"] * INSTRUCTIONS_PER_COUNT // counted["ticks"]
        yield "rod.m7_instructions", mean, "instructions", context
        if context == HASHED_CASE:
            yield "rod.m7_hash_instructions", counted["hash"], "instructions", "elements=256, a part of every tick"


def instructions(build, folder):
    make, image = os.path.join(build, "bench", "budget_make"), os.path.join(build, "m7", "budget_image.elf")
    for number, context in enumerate(run([make, "list"]).splitlines()):
        yield from measure_case(make, image, number, context, folder)


def profile(build, number, folder):
    """Runs the image in single steps, and counts, for each function, the instructions that two ticks execute."""
    make, image = os.path.join(build, "bench", "budget_make"), os.path.join(build, "m7", "budget_image.elf")
    path, log = os.path.join(folder, "case"), os.path.join(folder, "log")
    run([make, "make", number, path])
    found = sorted(
        (int(a, 16), name)
        for a, kind, name in (line.split() for line in run(["arm-none-eabi-nm", image]).splitlines())
        if kind in "tT"
    )
    starts = [address for address, _ in found]
    step = next(address for address, name in found if name == "crn_step")
    os.mkfifo(log)
    counts, ticks = collections.Counter(), 0
    command = QEMU + [
        "-singlestep",
        "-d",
        "exec,nochain",
        "-D",
        log,
        "-semihosting-config",
        "enable=on,target=native,arg=budget_image,arg=" + path,
        "-kernel",
        image,
    ]
    with (
        subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as qemu,
        open(log, encoding="ascii") as lines,
    ):
        for line in lines:
            match = re.search(r"/([0-9a-f]{8})/", line)
            address = int(match.group(1), 16) if match else 0
            ticks += address == step
            if ticks > 2:
                break
            if ticks:
                counts[found[bisect.bisect_right(starts, address) - 1][1]] += 1
        qemu.kill()
    for name, count in counts.most_common():
        print("%9.0f  %s" % (count / min(ticks, 2), name))


# --- objects: the files that the preset m7 made of a target --- ---------------------------------------------------
def target_folder(build, target):
    return os.path.join(build, "m7", "firmware", "images", "CMakeFiles", target + ".dir")


def budget_objects(build):
    return target_folder(build, "budget_core")


def image_objects(build, port):
    """Returns the folders of all object files that are linked into a port's image."""
    return [target_folder(build, "image_" + part) for part in ("core", "device", "memory", port)]


# --- stack -----------------------------------------------------------------------------------------------------------
def call_graph(folders):
    """Reads the compiler's .ci files, and returns each function's stack bytes and the functions that it calls, as two
    tables."""
    frame, calls, plain = {}, collections.defaultdict(set), {}
    folders = [folders] if isinstance(folders, str) else folders
    for path in [p for one in folders for p in glob.glob(os.path.join(one, "**", "*.ci"), recursive=True)]:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        for title, size, kind in re.findall(
            r'node: \{ title: "([^"]+)" label: "[^"]*\\n(\d+) bytes \(([^)]*)\)"', text
        ):
            if kind != "static":
                raise CannotMeasure("%s: its stack is %s, not static" % (title, kind))
            frame[title] = int(size)
            plain[title.split(":")[-1]] = title
        for source, target in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls[source].add(target)
    return frame, calls, plain


def worst_stack(folders, root, by_address=()):
    """Returns the largest sum of stack bytes along any path of calls that begins at the function `root`. Raises
    CannotMeasure for recursion and for functions whose stack size is unknown. `by_address` names all functions that can
    be called through a pointer; without it, the function refuses calls through pointers."""
    frame, calls, plain = call_graph(folders)
    frame, done = dict(frame), {}
    if by_address:
        frame["__indirect_call"], calls["__indirect_call"] = 0, set(by_address)

    def depth(name, above):
        title = name if name in frame else plain.get(name)
        if title is None:
            if ALLOWED_HELPERS.match(name):
                return 16, [name]  # leaf functions of libgcc that save at most four registers
            if DIVISION.match(name):
                return DIVISION_BYTES, [name]
            raise CannotMeasure("%s calls %s, of which the compiler told no stack size" % (above[-1], name))
        if title in above:
            raise CannotMeasure("recursion: %s" % " -> ".join(above + [title]))
        if title not in done:
            deepest = max((depth(target, above + [title]) for target in calls[title]), default=(0, []))
            done[title] = (frame[title] + deepest[0], [title.split(":")[-1]] + deepest[1])
        return done[title]

    return depth(root, [])


def stack(build):
    for root in ROOTS:
        size, path = worst_stack(budget_objects(build), root)
        yield "rod.m7_stack_bytes", size, "bytes", "function=%s" % root
        print("stack of %s: %s" % (root, " > ".join(path)), file=sys.stderr)


# --- bytes and symbols -----------------------------------------------------------------------------------------------
def sizes(build):
    objects = glob.glob(os.path.join(budget_objects(build), "**", "core", "*.obj"), recursive=True)
    lines = run(["arm-none-eabi-size"] + objects).splitlines()[1:]
    yield "rod.m7_text_bytes", sum(int(line.split()[0]) for line in lines), "bytes", "firmware/core with its tables"
    if sum(int(line.split()[1]) + int(line.split()[2]) for line in lines):
        raise CannotMeasure("the core has writable data")


def memory_sizes():
    """Compiles for the Cortex-M7 and returns the sizes, in bytes, of the core's model and state for three instruments
    with 256 elements in total."""
    text = (
        '#include "firmware/core/core_state.h"\nchar model_bytes[sizeof(crn_model)];\n'
        "char state_bytes[sizeof(crn_state)];\nchar words_bytes[sizeof(crn_state_words)];\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        target = os.path.join(folder, "sizes.o")
        run(
            [
                "arm-none-eabi-gcc",
                "-mcpu=cortex-m7",
                "-mthumb",
                "-std=c11",
                "-I.",
                "-DCRN_NODE_MAX=260",
                "-x",
                "c",
                "-c",
                "-fno-common",
                "-",
                "-o",
                target,
            ],
            text=text,
        )
        for line in run(["arm-none-eabi-nm", "-S", target]).splitlines():
            _, size, _, name = line.split()
            yield "rod.m7_" + name, int(size, 16), "bytes", "elements=256 tools=3"


def forbidden_symbols(image):
    """Returns the names of the forbidden functions that the firmware image contains. The test test_budget.py checks
    that this search finds a forbidden name."""
    names = [line.split()[-1] for line in run(["arm-none-eabi-nm", image]).splitlines()]
    return sorted(name for name in names if is_forbidden(name))


def is_forbidden(name):
    return bool(FORBIDDEN.match(name)) and not ALLOWED_HELPERS.match(name) and not MEMORY.match(name)


# --- static estimate -------------------------------------------------------------------------------------------------
INSTRUCTION = re.compile(r"^\s*([0-9a-f]+):\s+(\S.*)$")


def innermost_loops(lines):
    """Returns the instructions of every innermost loop; a loop extends from the target of a backward branch to this
    branch."""
    code = []
    for line in lines:
        match = INSTRUCTION.match(line)
        if match:
            code.append((int(match.group(1), 16), match.group(2).split("@")[0].split(";")[0].strip()))
    spans = []
    for index, (address, text) in enumerate(code):
        match = re.match(r"(?:b\w*(?:\.[nw])?|cbn?z\s+\w+,)\s+([0-9a-f]+) <", text)
        if match and int(match.group(1), 16) <= address:
            first = next((i for i, (a, _) in enumerate(code) if a == int(match.group(1), 16)), None)
            if first is not None:
                spans.append((first, index))
    for first, last in spans:
        inner = any(a >= first and b <= last and (a, b) != (first, last) for a, b in spans)
        if not inner and last - first >= LOOP_MIN:
            yield [text for _, text in code[first : last + 1]]


def estimate(body):
    """Returns the processor cycles that llvm-mca computes for one pass of the loop. Cache misses and branches are not
    counted."""
    kept = [
        text
        for text in body
        if not re.match(r"(b|bl|blx|bx|b(eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)|cbn?z)(\.[nw])?\s", text)
    ]
    kept = [re.sub(r"<[^>]*>", "", text) for text in kept]
    report = run(
        ["llvm-mca", "-mtriple=thumbv7em-none-eabi", "-mcpu=cortex-m7", "-iterations=100"],
        check=False,
        text="\n".join(kept) + "\n",
    )
    match = re.search(r"Total Cycles:\s+(\d+)", report)
    return (len(kept), int(match.group(1)) / 100) if match else None


def print_estimates(build):
    print(
        "\nstatic estimate by llvm-mca (cortex-m7), NOT measured: cycles per pass through the longest loop of "
        "a function, in order of\naddress, without cache misses and branches"
    )
    rows = []
    for path in sorted(glob.glob(os.path.join(budget_objects(build), "**", "core", "*.obj"), recursive=True)):
        text = run(["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", path])
        for name, body in re.findall(r"^[0-9a-f]+ <(\w+)>:\n(.*?)(?:\n\n|\Z)", text, re.M | re.S):
            found = [e for e in (estimate(loop) for loop in innermost_loops(body.splitlines())) if e]
            if found:
                rows.append((max(found), name))
    for (instructions_in_loop, cycles), name in sorted(rows, reverse=True)[:16]:
        print("  %-28s %4d instructions, %6.1f cycles" % (name, instructions_in_loop, cycles))


# --- tracked file ----------------------------------------------------------------------------------------------------
def read_budget():
    path = os.path.join(ROOT, BUDGET)
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        rows = [line.rstrip("\n").split("\t") for line in file if line.strip()]
    return {(name, key_of(context)): int(value) for name, value, _, context in rows}


def key_of(context):
    """The key of a budget row leaves out the fraction of ticks that need a second solve, because this fraction may
    change for the same benchmark case."""
    return context.split(" contacts=")[0] if "second_solve" in context else context


def judge(row, budget):
    """Returns '' if the measured row is within the budget, and otherwise a text that states the error."""
    name, value, _, context = row
    allowed = budget.get((name, key_of(context)))
    if allowed is None:
        return "has no row in " + BUDGET
    return "more than 3 %% over the budget of %d" % allowed if value > allowed * OVER else ""


def write_rows(path, rows):
    with open(os.path.join(ROOT, path), "w", encoding="utf-8") as file:
        file.writelines("%s\t%d\t%s\t%s\n" % row for row in rows)


def measure(build, folder):
    """Measures every row of the budget and returns these rows; run_bench.py also writes the rows into out/bench.tsv."""
    return list(instructions(build, folder)) + list(stack(build)) + list(sizes(build)) + list(memory_sizes())


def chip_cases(rows, folder):
    """Returns the cases whose instructions `rows` state, for chip_budget.measure; the files are still in `folder`."""
    counted = [row for row in rows if row[0] in ("rod.m7_instructions", "rod.m7_instructions_worst")]
    return [
        (
            case_path(folder, number),
            key_of(context),
            chip_budget.MOST if name.endswith("worst") else chip_budget.MEAN,
            value,
        )
        for number, (name, value, _, context) in enumerate(counted)
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build", help="build folder (default: build)")
    parser.add_argument("--accept", action="store_true", help="write what was measured to " + BUDGET)
    parser.add_argument("--search", action="store_true", help="look for dear ticks anew: " + chip_budget.FOUND)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="programs at once")
    parser.add_argument("--profile", metavar="CASE", help="where the instructions of a case go")
    options = parser.parse_args()
    failed = 0
    try:
        with tempfile.TemporaryDirectory() as folder:
            if options.profile:
                profile(options.build, options.profile, folder)
                return 0
            if options.search:
                chip_budget.search_all(options.build, options.jobs)
                return 0
            rows = measure(options.build, folder)
            rows += chip_budget.measure(options.build, folder, chip_cases(rows, folder), options.jobs)
        budget = read_budget()
        for row in rows:
            wrong = "" if options.accept else judge(row, budget)
            failed += bool(wrong)
            before = budget.get((row[0], key_of(row[3])))
            change = " (%+.1f %%)" % (100.0 * row[1] / before - 100) if before else ""
            print("%-28s %9d %-12s %s%s%s" % (*row, change, "  FAILED: " + wrong if wrong else ""))
        found = forbidden_symbols(os.path.join(options.build, "m7", "budget_image.elf"))
        failed += bool(found)
        print(
            "ELF: "
            + (
                "FAILED: the image holds " + ", ".join(found)
                if found
                else "no soft-float, no divide helper, no heap in the image"
            )
        )
        print_estimates(options.build)
    except (CannotMeasure, chip_budget.CannotPrice) as problem:
        print("budget: %s" % problem, file=sys.stderr)
        return 1
    if options.accept:
        write_rows(BUDGET, rows)
        print("written to %s" % BUDGET)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
