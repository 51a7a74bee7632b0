#!/usr/bin/env python3
"""The examples in docs/python.md, gymnasium.md, tasks.md and factory.md run from top to bottom, and docs/python.md
names every public class and exception. Prints TAP."""

import os
import re
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__))

import cournand  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402
import tree  # noqa: E402


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```", tree.read(page), flags=re.M | re.S)


def runs(page):
    """Runs the examples of a page one after the other in an empty folder; later examples can use the names of earlier
    ones."""
    names, before = {}, os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for number, block in enumerate(blocks(page), 1):
                exec(compile(block, "%s, example %d" % (page, number), "exec"), names)
        finally:
            os.chdir(before)
        return sorted(os.listdir(folder))


def the_examples_of_the_package_run():
    return len(blocks("docs/python.md")) >= 8 and runs("docs/python.md") == [
        "iliac.session",
        "led.rec",
        "mine.rec",
        "wire.png",
    ]


def the_examples_of_the_environments_run():
    return len(blocks("docs/gymnasium.md")) >= 4 and runs("docs/gymnasium.md") == []


def the_example_of_the_factory_runs():
    return len(blocks("docs/factory.md")) == 1 and runs("docs/factory.md") == []


def the_example_of_the_tasks_runs():
    return len(blocks("docs/tasks.md")) == 1 and runs("docs/tasks.md") == []


def the_five_lines_of_the_readme_give_a_picture():
    return len(blocks("README.md")) == 1 and runs("README.md") == ["wire.png"]


def the_page_names_every_class():
    page = tree.read("docs/python.md")
    classes = [name for name in cournand.__all__ if isinstance(getattr(cournand, name), type)]
    values = {"Contacts", "Fault", "Order", "PatientReading", "Place", "Pose", "Reading", "RecordingInfo", "Vessel"}
    missing = [name for name in classes if name not in values and not re.search("`(cournand\\.)?%s`" % name, page)]
    print("".join("# docs/python.md does not name %s\n" % name for name in missing), end="")
    return not missing


def everything_public_has_a_docstring():
    missing = []
    for name in cournand.__all__:
        thing = getattr(cournand, name)
        if isinstance(thing, type) and not (thing.__doc__ or "").strip():
            missing.append(name)
    for kind in (cournand.Scene, cournand.Tool, cournand.World, cournand.XRay, cournand.Recording, cournand.Batch):
        members = [(one, value) for one, value in vars(kind).items() if not one.startswith("_") and callable(value)]
        missing += ["%s.%s" % (kind.__name__, one) for one, value in members if not value.__doc__]
    print("".join("# no docstring: %s\n" % name for name in missing), end="")
    return not missing


tap.run(
    [
        the_examples_of_the_package_run,
        the_examples_of_the_environments_run,
        the_example_of_the_factory_runs,
        the_example_of_the_tasks_runs,
        the_five_lines_of_the_readme_give_a_picture,
        the_page_names_every_class,
        everything_public_has_a_docstring,
    ]
)
