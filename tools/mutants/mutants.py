#!/usr/bin/env python3
"""Asks whether the tests of the core notice a core that is wrong: docs/mutants.md.

  mutants.py --build build [--jobs 2] [--only NAME] [--list]

Every mutant of the table (tools/mutants/table) changes one thing in firmware/core: a constant by 5 %, a sign, a term.
The program compiles the changed files, and shows the core to the tests until one fails. Tests that look at a hash of
the state are not among them. Results are kept in out/mutants, so an interrupted run continues where it ended; a result
is used again while the core, the mutant and the test program are the same. The program writes out/mutants.tsv: one
line per mutant with the test that killed it, and the rows mutants.count, mutants.survivors and mutants.killed_pct.
Exit codes: 0 the share of killed mutants is at least 95 %; 1 it is not, or the table does not fit the sources, or a
test fails without a mutant; 2 usage.
"""

import argparse
import concurrent.futures
import glob
import hashlib
import json
import os
import shlex
import sys
import threading

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import suite
import table

HERE, ROOT = suite.HERE, suite.ROOT
CORE = os.path.join(ROOT, "firmware", "core")
FIRST = os.path.join(HERE, "first.tsv")
BAR_PCT = 95.0
BUDGETS_s = (2, 5, 20, 1000000)
INCLUDE = table.re.compile(r'#include "firmware/core/([^"]+)"')
CONSTANT = table.re.compile(r"\s*(CRN_\w+) = ")
DROPPED_FLAGS = ("-Werror", "-fvisibility=hidden", "-MD", "-g1", "-O3")
# The level changes no result, because the core computes with integers. It takes half of the compiler's time.
ADDED_FLAGS = ("-O2", "-w", "-fno-semantic-interposition")


def read_source(name):
    with open(os.path.join(CORE, name), encoding="utf-8") as file:
        return file.read()


def core_files():
    paths = glob.glob(os.path.join(CORE, "*.[ch]")) + glob.glob(os.path.join(CORE, "near", "*.[ch]"))
    return sorted(os.path.relpath(path, CORE) for path in paths)


def digest(*parts):
    sum_ = hashlib.sha256()
    for part in parts:
        sum_.update(part if isinstance(part, bytes) else part.encode())
    return sum_.hexdigest()[:16]


def file_digest(path):
    with open(path, "rb") as file:
        return digest(file.read())


def read_first():
    """Returns the test that each mutant is shown first; the file only saves time."""
    with open(FIRST, encoding="utf-8") as file:
        return dict(line.rstrip("\n").split("\t") for line in file if not line.startswith("#"))


def write_first(results):
    kills = sorted((mutant.name, killer) for mutant, killer, _ in results if killer)
    with open(FIRST, "w", encoding="utf-8") as file:
        file.write(
            "# The test that each mutant is shown first: the one that killed it last (mutants.py --write-first).\n"
        )
        file.write("".join("%s\t%s\n" % one for one in kills))


class Core:
    """Compiles the core's files as the build does, and links them to a shared library."""

    def __init__(self, build, folder):
        self.folder = folder
        with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
            entries = json.load(file)
        prefix = os.path.join(CORE, "")
        self.commands = {
            os.path.relpath(entry["file"], CORE): entry for entry in entries if entry["file"].startswith(prefix)
        }
        if not self.commands:
            raise suite.CannotRun("%s/compile_commands.json does not compile firmware/core" % build)
        self.texts = {name: read_source(name) for name in core_files()}
        self.key = digest(*(name + "\n" + text for name, text in sorted(self.texts.items())))

    def affected(self, changed, edits):
        """Returns the sources to compile when files have changed: themselves, and all that include them. A constant of
        a header that no other header mentions affects only the sources that mention it."""
        names = {CONSTANT.match(old)[1] for name, old, _ in edits if name.endswith(".h") and CONSTANT.match(old)}
        if len(names) == len(edits) == 1:
            users = {name for name, text in self.texts.items() if table.re.search(r"\b%s\b" % names.copy().pop(), text)}
            if not any(name.endswith(".h") for name in users - set(changed)):
                return sorted(users & set(self.commands))
        reached = set(changed)
        while True:
            more = {
                name
                for name, text in self.texts.items()
                if name not in reached and reached & set(INCLUDE.findall(text))
            }
            if not more:
                return sorted(reached & set(self.commands))
            reached |= more

    def compile(self, name, folder, changed):
        entry = self.commands[name]
        words = [word for word in shlex.split(entry["command"]) if word not in DROPPED_FLAGS]
        for option in ("-o", "-c", "-MF", "-MT"):
            if option in words:
                at = words.index(option)
                del words[at : at + 2]
        source = os.path.join(folder, "firmware", "core", name) if name in changed else os.path.join(CORE, name)
        at = next(i for i, word in enumerate(words) if word.startswith("-I"))
        words[at:at] = ["-I", folder]
        target = os.path.join(folder, name.replace("/", "_") + ".o")
        suite.output_of([*words, *ADDED_FLAGS, "-c", source, "-o", target], cwd=entry["directory"])
        return target

    def build(self, name, changed, edits=(), jobs=1):
        """Builds the core with changed sources in a folder of its own; returns the library."""
        folder = os.path.join(self.folder, name)
        for file_name, text in changed.items():
            path = os.path.join(folder, "firmware", "core", file_name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        os.makedirs(folder, exist_ok=True)
        base = os.path.join(self.folder, "core")
        objects = {one: os.path.join(base, one.replace("/", "_") + ".o") for one in self.commands}
        names = self.affected(changed, edits) if changed else sorted(self.commands)
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            objects.update(zip(names, pool.map(lambda one: self.compile(one, folder, changed), names)))
        library = os.path.join(folder, "libcore.so")
        suite.output_of(
            ["cc", "-shared", "-fuse-ld=lld", "-Wl,-soname,libcore.so", *sorted(objects.values()), "-o", library]
        )
        return library


class Kept:
    """Results of earlier runs, in one file; each result has the keys under which it is true."""

    def __init__(self, path):
        self.path, self.lock = path, threading.Lock()
        try:
            with open(path, encoding="utf-8") as file:
                self.results = json.load(file)
        except (OSError, ValueError):
            self.results = {}

    def get(self, key):
        return self.results.get(key)

    def put(self, key, result):
        with self.lock:
            self.results[key] = result
            with open(self.path + ".new", "w", encoding="utf-8") as file:
                json.dump(self.results, file, indent=0, sort_keys=True)
            os.replace(self.path + ".new", self.path)


class Judge:
    def __init__(self, core, programs, tests, kept, limit_s):
        self.core, self.programs, self.tests, self.kept, self.limit_s = core, programs, tests, kept, limit_s
        self.program_keys = {test.program: file_digest(programs.path(test.program)) for test in tests}
        self.seconds, self.kills, self.libraries, self.first = {}, {}, {}, read_first()
        self.lock = threading.Lock()

    def key_of(self, test, core_key):
        return digest(core_key, self.program_keys[test.program], str(test))

    def baseline(self, library, jobs):
        """Runs every test with the core as it is. Returns the tests that fail."""

        def run(test):
            key = "baseline " + self.key_of(test, self.core.key)
            result = self.kept.get(key)
            if result is None:
                why, used_s = self.programs.run(test, library, 600)
                result = {"why": why, "seconds": round(used_s, 2)}
                if not why:
                    self.kept.put(key, result)
            return result

        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            results = list(pool.map(run, self.tests))
        self.seconds = {test: result["seconds"] for test, result in zip(self.tests, results)}
        return ["%s: %s" % (test, result["why"]) for test, result in zip(self.tests, results) if result["why"]]

    def order(self, mutant):
        """The test that killed the mutant before comes first, then those that end soon or have killed mutants of the
        same file."""
        files = {edit[0] for edit in mutant.edits}

        def price(test):
            if str(test) == self.first.get(mutant.name):
                return 0
            kills = sum(self.kills.get((test, name), 0) for name in files)
            return (self.seconds[test] + 0.05) / (1 + 4 * kills)

        return sorted(self.tests, key=price)

    def judge(self, mutant, changed, budget_s):
        """Returns the test that kills a mutant and the reason; ("", "") if none does; None if tests are left that would
        take more than the budget."""
        mutant_key = digest(self.core.key, *(name + "\n" + text for name, text in sorted(changed.items())))
        order = self.order(mutant)
        known = {test: self.kept.get(self.key_of(test, mutant_key)) for test in order}
        killer = next((test for test in order if known[test]), None)
        for test in order:
            if killer or known[test] is not None:
                continue
            budget_s -= self.seconds[test] + 0.05
            if budget_s < 0:
                return None
            if mutant.name not in self.libraries:
                self.libraries[mutant.name] = self.core.build(mutant.name, changed, mutant.edits)
            limit_s = int(5 * self.seconds[test] + self.limit_s)
            known[test], _ = self.programs.run(test, self.libraries[mutant.name], limit_s)
            self.kept.put(self.key_of(test, mutant_key), known[test])
            killer = test if known[test] else None
        if killer is None:
            return "", ""
        with self.lock:
            for name in {edit[0] for edit in mutant.edits}:
                self.kills[killer, name] = self.kills.get((killer, name), 0) + 1
        return str(killer), known[killer]


def figures_of(results):
    counted = [one for one in results if not one[0].equivalent]
    survivors = sum(not killer for _, killer, _ in counted)
    share = 100 * (len(counted) - survivors) / max(1, len(counted))
    return len(counted), survivors, share


def write_results(path, results):
    count, survivors, share = figures_of(results)
    lines = ["mutant\tfile\tkilled by\thow\twhat it does"]
    for mutant, killer, why in results:
        by = killer or ("equivalent: " + mutant.equivalent if mutant.equivalent else "nobody")
        files = " ".join(sorted({edit[0] for edit in mutant.edits}))
        lines.append("\t".join((mutant.name, files, by, why.replace("\t", " "), mutant.means)))
    lines += [
        "mutants.count\t%d" % count,
        "mutants.survivors\t%d" % survivors,
        "mutants.killed_pct\t%.1f" % share,
    ]
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def prepare(arguments, folder):
    """Builds the core as it is and the test programs, and returns a judge whose baseline has passed."""
    core = Core(arguments.build, folder)
    library = core.build("core", {}, (), arguments.jobs)
    programs = suite.Programs(arguments.build, os.path.join(folder, "programs"), library)
    tests, excluded = suite.unit_tests(arguments.units.split())
    for program in dict.fromkeys(test.program for test in tests):
        programs.link(program)
    if not arguments.no_cases:
        programs.link(suite.VALIDATE)
        tests += programs.cases()
    for test in excluded:
        print("left out, because it uses a hash: %s" % test, flush=True)
    judge = Judge(core, programs, tests, Kept(os.path.join(folder, "results.json")), arguments.limit_s)
    failed = judge.baseline(library, arguments.jobs)
    if failed:
        raise suite.CannotRun("without a mutant these tests fail; mend them first:\n  " + "\n  ".join(failed))
    print("%d tests pass without a mutant, in %.0f s" % (len(tests), sum(judge.seconds.values())), flush=True)
    return judge


def run_all(judge, mutants, sources, jobs):
    """Shows every mutant first to a few tests, then those that live to more, then the rest to all: most die early."""
    results = {}

    def run(mutant, budget_s):
        try:
            result = judge.judge(mutant, sources[mutant.name], budget_s)
        except suite.CannotRun as problem:
            raise table.BadTable("%s does not run: %s" % (mutant.source, problem)) from problem
        if result is None:
            return
        results[mutant.name] = (mutant, *result)
        verdict = "killed by %s (%s)" % result if result[0] else "SURVIVES: " + mutant.means
        if mutant.equivalent:
            verdict += "; the table says that it is equivalent: " + mutant.equivalent
        print("%3d/%d  %s: %s" % (len(results), len(mutants), mutant.name, verdict), flush=True)

    for budget_s in BUDGETS_s:
        left = [mutant for mutant in mutants if mutant.name not in results]
        if left:
            print("%d mutants, at most %s s of tests for each" % (len(left), budget_s), flush=True)
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            futures = [pool.submit(run, mutant, budget_s) for mutant in left]
            try:
                for future in futures:
                    future.result()
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    return [results[mutant.name] for mutant in mutants]


def finish(results, is_whole, arguments):
    """Prints the figures; returns the exit code."""
    wrong = [mutant.source for mutant, killer, _ in results if killer and mutant.equivalent]
    for source in wrong:
        print("%s: called equivalent, but a test notices it; remove the field `equivalent`" % source)
    count, survivors, share = figures_of(results)
    if is_whole:
        write_results(arguments.output, results)
        print("written: %s" % arguments.output)
        if arguments.write_first:
            write_first(results)
    print("mutants.count\t%d\nmutants.survivors\t%d\nmutants.killed_pct\t%.1f" % (count, survivors, share))
    return 1 if wrong or share < BAR_PCT else 0


def parsed_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.environ.get("BUILD", "build"))
    parser.add_argument("--jobs", type=int, default=2, help="mutants at once (default: 2)")
    parser.add_argument("--only", default="", help="only mutants with this text in their name; writes no table")
    parser.add_argument("--list", action="store_true", help="check the table, print its mutants, and stop")
    parser.add_argument("--table", default=os.path.join(HERE, "table"), help="folder with the table")
    parser.add_argument("--folder", default="out/mutants", help="folder for what is built and known")
    parser.add_argument("-o", "--output", default="out/mutants.tsv")
    parser.add_argument("--write-first", action="store_true", help="keep the killers in first.tsv; saves time")
    parser.add_argument("--units", default=" ".join(suite.UNITS), help="test programs of firmware/tests: 'rod tools'")
    parser.add_argument(
        "--limit-s", type=int, default=10, help="a test may take so long beside five times its usual time"
    )
    parser.add_argument("--no-cases", action="store_true", help="leave the cases of the validation suite out")
    arguments = parser.parse_args()
    if arguments.jobs < 1:
        parser.error("--jobs: at least 1")
    return arguments


def main():
    arguments = parsed_arguments()
    os.chdir(ROOT)
    try:
        mutants = table.read(arguments.table)
        sources = {mutant.name: table.apply(mutant, read_source) for mutant in mutants}
        chosen = [mutant for mutant in mutants if arguments.only in mutant.name]
        if not chosen:
            print("mutants.py: no mutant has '%s' in its name; --list prints the names" % arguments.only)
            return 2
        if arguments.list:
            print("\n".join("%s: %s" % (mutant.name, mutant.means) for mutant in chosen))
            return 0
        arguments.build = os.path.abspath(arguments.build)
        judge = prepare(arguments, os.path.abspath(arguments.folder))
        results = run_all(judge, chosen, sources, arguments.jobs)
        return finish(results, len(chosen) == len(mutants), arguments)
    except (table.BadTable, suite.CannotRun) as problem:
        print("mutants.py: %s" % problem, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted; what is known is kept, and the next run goes on", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
