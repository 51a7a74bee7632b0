#!/usr/bin/env python3
"""Tests that tools/bench/budget.py finds four faults: a value over the budget, a forbidden helper in the image,
recursion, and calls by address. The script also tests that the last scene of the budget still has a
tick in which the core solves its equations twice. The test does not measure the cost of a tick; `make budget` measures
it. Prints TAP."""

import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import tree  # noqa: E402

sys.path.insert(0, os.path.join(tree.ROOT, "tools", "bench"))
import budget  # noqa: E402

GRAPHS = {
    "recursion": "int down(int a); int down(int a) { return a ? down(a - 1) + a : 0; }\n"
    "int crn_step(int a) { return down(a); }\n",
    "a call by address": "int crn_step(int (*f)(int)) { return f(1) + 1; }\n",
    "a stack that grows": "void use(char *); void use(char *a) { *a = 1; }\n"
    "int crn_step(int n) { char a[n]; use(a); return a[0]; }\n",
}


def stack_of(text):
    """Compiles a C text and returns (bytes, '') with the worst stack of its function crn_step, or (None, reason) if the
    stack cannot be determined."""
    with tempfile.TemporaryDirectory() as folder:
        objects = os.path.join(folder, "m7", "obj")
        os.makedirs(objects)
        source = os.path.join(folder, "sample.c")
        with open(source, "w", encoding="ascii") as file:
            file.write(text)
        subprocess.run(
            [
                "arm-none-eabi-gcc",
                "-mcpu=cortex-m7",
                "-mthumb",
                "-O1",
                "-fno-inline",
                "-fno-optimize-sibling-calls",
                "-fstack-usage",
                "-fcallgraph-info=su",
                "-c",
                source,
                "-o",
                os.path.join(objects, "sample.o"),
            ],
            check=True,
        )
        try:
            return budget.worst_stack(folder, "crn_step")[0], ""
        except budget.CannotMeasure as problem:
            return None, str(problem)


def known_stack():
    size, why = stack_of(
        "void use(char *); __attribute__((noinline)) void use(char *a) { *a = 1; }\n"
        "int crn_step(int n) { char a[100]; use(a); return a[0] + n; }\n"
    )
    if size is None or not 100 <= size <= 128:
        yield "100 bytes of locals give %s %s" % (size, why)


def budget_rows():
    for (name, context), value in budget.read_budget().items():
        if value <= 0:
            yield "%s %s: %d" % (name, context, value)
    if ("rod.m7_instructions", "elements=256 contacts=all") not in budget.read_budget():
        yield "no row for 256 elements, all touching"


def second_solve():
    """A change of the rod model may change the ticks in which the core solves twice, but the scene must still contain a
    tick with two solutions."""
    program = os.path.join(os.environ.get("BUILD", "build"), "bench", "budget_make")
    scenes = subprocess.run([program, "list"], stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    number = next(i for i, scene in enumerate(scenes) if "second_solve" in scene)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [program, "make", str(number), os.path.join(folder, "case")],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
    if done.returncode != 0:
        yield done.stdout.strip()


def main():
    report = tree.Report()
    allowed = {("a", "x"): 1000}
    report.catches("a row 4 % over its budget is caught", [budget.judge(("a", 1040, "", "x"), allowed)])
    report.catches("a row without a budget is caught", [budget.judge(("b", 1, "", "x"), allowed)])
    report.accepts(
        "a row 2 % over its budget is accepted", [w for w in [budget.judge(("a", 1020, "", "x"), allowed)] if w]
    )
    for name in (
        "__aeabi_fadd",
        "__aeabi_ddiv",
        "__aeabi_uldivmod",
        "__aeabi_idiv",
        "__udivmoddi4",
        "__adddf3",
        "malloc",
    ):
        report.catches("%s in the image is caught" % name, [name] if budget.is_forbidden(name) else [])
    report.accepts(
        "64-bit shifts and memcpy in the image are accepted",
        [n for n in ("__aeabi_llsl", "__aeabi_memcpy4", "memset", "crn_step") if budget.is_forbidden(n)],
    )
    for name, text in GRAPHS.items():
        report.catches("%s in the call graph is caught" % name, [why for why in [stack_of(text)[1]] if why])
    report.check("the worst stack of a known function is right", known_stack())
    report.check("firmware/bench/budget.tsv has its rows", budget_rows())
    report.check("the scene of the second solve has one", second_solve())
    report.end()


if __name__ == "__main__":
    main()
