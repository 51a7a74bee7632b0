#!/usr/bin/env python3
"""Tests `make mutants` (docs/mutants.md) with small tables of its own and two test programs: a mutant that a test can
notice is killed, one that changes nothing lives, a table that does not fit the sources is refused with its place.
Prints TAP."""

import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "tools", "mutants"))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import mutants  # noqa: E402
import suite  # noqa: E402
import table  # noqa: E402
import tap  # noqa: E402

WORK = tempfile.TemporaryDirectory()
DIES = ("dies", "fixed.c", "*sin_q30 = cosine, *cos_q30 = -sine;", "*sin_q30 = cosine, *cos_q30 = sine;")
LIVES = (
    "lives",
    "fixed.c",
    "(root + ((uint64_t)1 << (drop - 1))) >> drop;",
    "(((uint64_t)1 << (drop - 1)) + root) >> drop;",
)
ENDLESS = ("endless", "fixed.c", "for (int bit = 63; bit >= 0; bit--) {", "for (int bit = 63; bit >= 0; bit = 63) {")


def entry(name, file, old, new, more=""):
    return '[[mutant]]\nname = "%s"\nmeans = "a test"\n%s\nedits = [["%s", "%s", "%s"]]\n' % (
        name,
        more,
        file,
        old,
        new,
    )


def run(text, *arguments):
    """Runs the program with a table of this text; returns its exit code, what it said, and the table it wrote."""
    folder = os.path.join(WORK.name, "table")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "one.toml"), "w", encoding="utf-8") as file:
        file.write(text)
    output = os.path.join(WORK.name, "mutants.tsv")
    if os.path.exists(output):
        os.unlink(output)
    command = [sys.executable, os.path.join(ROOT, "tools", "mutants", "mutants.py"), "--table", folder, "-o", output]
    command += ["--folder", os.path.join(WORK.name, "work"), "--units", "fixed vector", "--no-cases", "--limit-s", "1"]
    ended = subprocess.run([*command, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    written = open(output, encoding="utf-8").read() if os.path.exists(output) else ""
    return ended.returncode, ended.stdout + ended.stderr, written


def is_refused(text, *words):
    code, said, written = run(text)
    return code == 1 and written == "" and all(word in said for word in words)


def a_mutant_that_a_test_notices_is_killed_and_one_that_changes_nothing_lives():
    code, said, written = run(entry(*DIES) + entry(*LIVES))
    return (
        code == 1  # the share of 50 % is below the bar
        and "SURVIVES" in said
        and re.search(r"^dies\tfixed.c\ttest_fixed: sine_and_cosine", written, re.M) is not None
        and re.search(r"^lives\tfixed.c\tnobody\t", written, re.M) is not None
        and "mutants.count\t2\nmutants.survivors\t1\nmutants.killed_pct\t50.0\n" in written
    )


def an_equivalent_mutant_counts_for_nothing_and_is_named():
    code, said, written = run(entry(*DIES) + entry(*LIVES, 'equivalent = "a sum has no order"'))
    return code == 0 and "mutants.count\t1\n" in written and "equivalent: a sum has no order" in written


def a_mutant_that_is_called_equivalent_and_dies_is_an_error():
    code, said, _ = run(entry(*DIES, 'equivalent = "so they say"'))
    return code == 1 and "called equivalent, but a test notices it" in said


def a_mutant_that_does_not_end_is_killed_by_time():
    code, said, written = run(entry(*ENDLESS))
    return code == 0 and "no end after" in written


def results_are_kept_for_the_next_run():
    first, again = run(entry(*DIES)), run(entry(*DIES))
    return first[0] == again[0] == 0 and first[2] == again[2]


def a_part_of_the_table_writes_no_results():
    code, said, written = run(entry(*DIES) + entry(*LIVES), "--only", "dies")
    return code == 0 and written == "" and "mutants.count\t1" in said


def a_stale_table_is_refused():
    return is_refused(entry("old", "fixed.c", "no such text", "x"), "one.toml: old:", "0 times in fixed.c", "stale")


def a_text_that_occurs_twice_is_refused():
    return is_refused(entry("twice", "fixed.c", "polynomial_q31(", "x"), "times in fixed.c", "found once")


def a_file_that_does_not_exist_is_refused():
    return is_refused(entry("none", "no_such.c", "a", "b"), "one.toml: none: no_such.c: No such file")


def a_mutant_that_does_not_compile_is_refused():
    return is_refused(entry("broken", *DIES[1:3], "this is no C"), "one.toml: broken", "does not run")


def a_bad_table_is_refused():
    return (
        is_refused(entry(*DIES).replace("means", "meens"), "unknown field 'meens'")
        and is_refused(entry(*DIES) + entry(*DIES), "occurs twice")
        and is_refused(entry("Bad Name", *DIES[1:]), "'Bad Name'")
        and is_refused("[[mutant", "one.toml")
    )


def bad_arguments_are_refused():
    one = entry(*DIES)
    return [run(one, "--jobs", "0")[0], run(one, "--what")[0], run(one, "--only", "nothing")[0]] == [2, 2, 2]


def the_shipped_table_fits_the_sources():
    shipped = table.read(os.path.join(ROOT, "tools", "mutants", "table"))
    for mutant in shipped:
        table.apply(mutant, mutants.read_source)
    return len(shipped) >= 60


def tests_with_a_hash_are_left_out():
    text = (
        "static int helper(void)\n{\n    return hash64();\n}\n\n"
        "static void with(void **c)\n{\n    helper();\n}\n\n"
        "static void without(void **c)\n{\n    assert_true(1);\n}\n\n"
        "int main(void)\n{\n    x = {cmocka_unit_test(with), cmocka_unit_test(without)};\n}\n"
    )
    tests, excluded = suite.unit_tests()
    return (
        suite.tests_of_source(text) == (["with", "without"], ["with"])
        and len(tests) > 100
        and any(test.name == "exchange_enters_the_hash" for test in excluded)
        and not any("hash" in test.name for test in tests)
    )


def the_build_has_a_target_for_every_program():
    with open(os.path.join(ROOT, "tools", "mutants", "CMakeLists.txt"), encoding="utf-8") as file:
        listed = re.search(r"foreach\(unit ([^)]*)\)", file.read())[1].split()
    return listed == sorted(suite.UNITS)


TESTS = (
    a_mutant_that_a_test_notices_is_killed_and_one_that_changes_nothing_lives,
    an_equivalent_mutant_counts_for_nothing_and_is_named,
    a_mutant_that_is_called_equivalent_and_dies_is_an_error,
    a_mutant_that_does_not_end_is_killed_by_time,
    results_are_kept_for_the_next_run,
    a_part_of_the_table_writes_no_results,
    a_stale_table_is_refused,
    a_text_that_occurs_twice_is_refused,
    a_file_that_does_not_exist_is_refused,
    a_mutant_that_does_not_compile_is_refused,
    a_bad_table_is_refused,
    bad_arguments_are_refused,
    the_shipped_table_fits_the_sources,
    tests_with_a_hash_are_left_out,
    the_build_has_a_target_for_every_program,
)
tap.run(TESTS)
