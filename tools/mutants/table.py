"""Reads the table of mutants (tools/mutants/table), and applies a mutant to the sources of the core.

A mutant has a name, a sentence that says what it means, and edits. An edit names a file of the core, a text that occurs
exactly once in it, and the text that takes its place:

    [[mutant]]
    name = "gravity_off_by_5_pct"
    means = "gravity is 5 % too strong"
    edits = [["core_build.c", "scaled(gravity[k], 1u << 20, 1000u)", "scaled(gravity[k], 1101005, 1000u)"]]

A mutant that no test can notice has the field `equivalent`, which gives the reason. It counts neither as killed nor as
a survivor.
"""

import dataclasses
import glob
import os
import re
import tomllib

NAME = re.compile(r"[a-z][a-z0-9_]*")
FIELDS = {"name", "means", "edits", "equivalent"}


class BadTable(Exception):
    """The table does not fit the sources, or is no table."""


@dataclasses.dataclass
class Mutant:
    name: str
    means: str
    edits: list
    equivalent: str
    source: str  # where the table has it, for messages


def checked(entry, source):
    unknown = set(entry) - FIELDS
    if unknown:
        raise BadTable("%s: unknown field '%s'; remove it" % (source, sorted(unknown)[0]))
    if not NAME.fullmatch(entry.get("name", "")):
        raise BadTable("%s: the name '%s' is not of the form wall_half_as_stiff" % (source, entry.get("name", "")))
    source = "%s: %s" % (source, entry["name"])
    if not isinstance(entry.get("means"), str) or not entry["means"]:
        raise BadTable("%s: no `means`; say in one sentence what the mutant does" % source)
    edits = entry.get("edits")
    if not edits or not all(len(edit) == 3 and all(isinstance(part, str) for part in edit) for edit in edits):
        raise BadTable("%s: `edits` is not a list of [file, text, other text]" % source)
    return Mutant(entry["name"], entry["means"], edits, entry.get("equivalent", ""), source)


def read(folder):
    """Returns the mutants of all tables in a folder, in the order of the files' names."""
    mutants, names = [], set()
    for path in sorted(glob.glob(os.path.join(folder, "*.toml"))):
        with open(path, "rb") as file:
            try:
                entries = tomllib.load(file).get("mutant", [])
            except tomllib.TOMLDecodeError as problem:
                raise BadTable("%s: %s" % (path, problem)) from problem
        for entry in entries:
            mutant = checked(entry, path)
            if mutant.name in names:
                raise BadTable("%s: this name occurs twice; choose another one" % mutant.source)
            names.add(mutant.name)
            mutants.append(mutant)
    if not mutants:
        raise BadTable("%s: no table of mutants (*.toml) is there" % folder)
    return mutants


def apply(mutant, read_source):
    """Returns the changed sources of a mutant, by the file's name. `read_source` returns the text of a file."""
    changed = {}
    for name, old, new in mutant.edits:
        try:
            text = changed.get(name) or read_source(name)
        except OSError as problem:
            raise BadTable("%s: %s: %s" % (mutant.source, name, problem.strerror)) from problem
        count = text.count(old)
        if count != 1 or old == new:
            what = "replaces a text by itself" if old == new else "finds its text %d times in %s" % (count, name)
            raise BadTable(
                "%s: %s, and it must be found once: the table is stale, adapt it to the source\n  text: %s"
                % (mutant.source, what, old)
            )
        changed[name] = text.replace(old, new)
    return changed
