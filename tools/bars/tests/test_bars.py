#!/usr/bin/env python3
"""Tests `make bars` (docs/bars.md): no bar (limit) vanishes from the list, a value beyond its bar fails, and a measured
time never fails. Prints TAP."""

import glob
import os
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "tools", "bars"))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import bars  # noqa: E402
import flakes  # noqa: E402
import tap  # noqa: E402


def bar(op="<=", limit=10.0, source="budget", kind="count"):
    return bars.Bar("a.bar", op, limit, "10", "1", "abc", source, kind)


def committed_names():
    with open(os.path.join(ROOT, "tools", "bars", "names.txt"), encoding="utf-8") as file:
        return file.read().split("\n")[:-1]


def no_bar_vanishes_and_none_is_there_twice():
    """Whoever abandons a bar (limit) must also remove its name from names.txt, in a commit that gives the reason."""
    return [one.name for one in bars.read_bars()] == committed_names() == list(dict.fromkeys(committed_names()))


def a_value_over_its_bar_is_red_and_one_at_it_is_held():
    return [bars.judge(bar(), value) for value in (10, 10.1)] == ["held", "red"] and bars.judge(bar(">="), 9.9) == "red"


def a_time_is_never_red():
    return bars.judge(bar(source="file:out/bench.tsv", kind="time"), 1e9) == "time"


def what_another_command_has_not_measured_is_named_and_neither_held_nor_red():
    return bars.judge(bar(source="file:out/none.tsv"), None) == "not measured here"


def what_cannot_be_measured_here_is_red():
    return bars.judge(bar(), None) == "red"


def a_damaged_line_is_refused_with_its_number():
    with tempfile.NamedTemporaryFile("w", suffix=".tsv", delete=False) as file:
        file.write("# head\nname\t<\t1\n")
    try:
        bars.read_bars(file.name)
    except bars.CannotMeasure as problem:
        return ":2:" in str(problem)
    finally:
        os.unlink(file.name)
    return False


def files_of_other_commands_are_read_by_name_and_context():
    with tempfile.NamedTemporaryFile("w", suffix=".tsv", delete=False) as file:
        file.write("soak.broken\t0\nrod.step_us\t61.5\tus\telements=256 contacts=57+ tools=1\n")
    try:
        return bars.from_file(file.name, ["soak.broken", "rod.step_us elements=256"]) == {
            "soak.broken": 0,
            "rod.step_us elements=256": 61.5,
        }
    finally:
        os.unlink(file.name)


def a_figure_beyond_its_tolerance_is_counted():
    head = "name\tformula\tsource\tunit\treference\tvalue\terror\ttolerance\terror_unit\tverdict\n"
    rows = (
        "euler.a\tf\ts\tN\t1\t1\t-1.5\t3\t%\tpass\n"
        "euler.b\tf\ts\tN\t1\t2\t4\t3\t%\tFAIL\n"
        "lag.c\tf\ts\tdeg\t-\t2\t-\t-\tdeg\treported\n"
    )
    values = bars.validation_values(head + rows)
    return (
        values["validation.figures_beyond_their_tolerance"] == 1
        and abs(values["validation.euler.worst_of_tolerance"] - 4 / 3) < 1e-12
    )


def edges_are_late_beyond_1_ms():
    return bars.overrun_values([400.0, 1000.0, 1000.04]) == {
        "hil.edges_over_1_ms at=500_mips": 1,
        "hil.edge_us_max at=500_mips": 1000.04,
    }


def is_refused(ticks):
    try:
        bars.checked_ticks(ticks)
    except bars.CannotMeasure:
        return True
    return False


def a_session_cut_short_or_without_cost_holds_no_bar():
    whole = [1.0] * bars.SESSION_TICKS
    return not is_refused(whole) and is_refused(whole[1:]) and is_refused(whole + [0.0]) and is_refused([])


def every_test_that_is_repeated_beside_a_load_exists():
    names = flakes.read_list("")
    return len(names) >= 15 and all(
        any(os.path.exists(os.path.join(ROOT, name + end)) for end in ("", ".c", ".cpp")) for name in names
    )


def a_test_that_opens_a_window_or_a_mocked_bus_is_repeated_beside_a_load():
    found = []
    for path in glob.glob(os.path.join(ROOT, "*", "*", "test_*.sh")) + glob.glob(
        os.path.join(ROOT, "*", "*", "*", "test_*.sh")
    ):
        with open(path, encoding="utf-8") as file:
            text = file.read()
        if "display.sh" in text or "mock_bus" in text:
            found.append(os.path.relpath(path, ROOT))
    return len(found) >= 4 and not set(found) - set(flakes.read_list(""))


TESTS = (
    every_test_that_is_repeated_beside_a_load_exists,
    a_test_that_opens_a_window_or_a_mocked_bus_is_repeated_beside_a_load,
    no_bar_vanishes_and_none_is_there_twice,
    a_value_over_its_bar_is_red_and_one_at_it_is_held,
    a_time_is_never_red,
    what_another_command_has_not_measured_is_named_and_neither_held_nor_red,
    what_cannot_be_measured_here_is_red,
    a_damaged_line_is_refused_with_its_number,
    files_of_other_commands_are_read_by_name_and_context,
    a_figure_beyond_its_tolerance_is_counted,
    edges_are_late_beyond_1_ms,
    a_session_cut_short_or_without_cost_holds_no_bar,
)
tap.run(TESTS)
