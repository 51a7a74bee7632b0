#!/usr/bin/env python3
"""Tests the file readers of the project's programs with malformed meshes, TOML files, scans and centrelines.

`make importers` tests the readers with all files, and `make test` with a small part of the files.

  importers.py --program build/bin/importers --files 3600 -o out/importers.tsv

The files are pseudo-random mutations of valid files (see --seed), and a list of hand-made files. The program
`importers` runs the same file readers as the project's other programs. If a reader accepts a file, strict.py also reads
this file, and the two must read the same content. If the two readings differ, the project's reader has misread the file
without reporting an error. The output has the rows importers.files, importers.crashes, importers.over_20s,
importers.over_2GB and importers.silently_wrong. A crash means that the program ended, or that a sanitizer found an
error in our code. The exit code is 0 if the values of all rows except the first are 0, and otherwise 1.
"""

import argparse
import glob
import json
import math
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import corpus
import strict

TIME_MAX_S, MEMORY_MAX_MiB = 20.0, 2048
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class Reader:
    """Represents the running program `importers`, and starts the program again whenever it has ended."""

    def __init__(self, program, folder):
        self.program, self.folder, self.process, self.MiB_before = program, folder, None, 0

    def start(self):
        options = "log_path=%s:abort_on_error=0:detect_leaks=0:allocator_may_return_null=1" % os.path.join(
            self.folder, "report"
        )
        self.noise = open(os.path.join(self.folder, "stderr"), "ab")
        self.process = subprocess.Popen(
            [self.program, "read"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.noise,
            env=dict(os.environ, ASAN_OPTIONS=options, UBSAN_OPTIONS=options + ":print_stacktrace=1"),
        )
        self.MiB_before = 0

    def stop(self):
        if self.process:
            self.process.kill()
            self.process.wait()
            self.process.stdin.close()
            self.process.stdout.close()
            self.noise.close()
        self.process = None

    def ask(self, kind, path):
        """Returns the line that the program `importers` prints about a file. Returns None if the program has ended,
        or if it printed nothing within three times the time limit.
        """
        if not self.process:
            self.start()
        self.process.stdin.write(("%s\t%s\n" % (kind, path)).encode())
        self.process.stdin.flush()
        if not select.select([self.process.stdout], [], [], 3 * TIME_MAX_S)[0]:
            self.stop()
            return None
        line = self.process.stdout.readline()
        if not line:
            self.stop()
            return None
        answer = json.loads(line)
        answer["is_over"] = answer["MiB"] > MEMORY_MAX_MiB and answer["MiB"] > self.MiB_before
        self.MiB_before = max(self.MiB_before, answer["MiB"])
        return answer


def reports(folder):
    """Returns the sanitizers' reports about this project's code. Reports about a library's parser are left out, because
    an error in such a parser ends only the child process."""
    found = []
    for path in glob.glob(os.path.join(folder, "report*")):
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read()
        os.remove(path)
        frames = [line for line in text.splitlines() if line.strip().startswith("#")]
        first = next(
            (
                line
                for line in frames
                if "libasan" not in line and "__interceptor" not in line and "sanitizer" not in line
            ),
            "",
        )
        if "runtime error" in text or "crn::" in first:
            found.append(text[:3000])
    return found


def near(a, b):
    if a is None or b is None:
        return True
    if isinstance(a, list):
        return len(a) == len(b) and all(near(x, y) for x, y in zip(a, b))
    if isinstance(a, float) and not math.isfinite(a):
        return True  # nothing to compare, as in a file without triangles
    return abs(a - b) <= 1e-5 * max(1.0, abs(a), abs(b))


def disagreement(path, data, answer):
    """Returns the reason why the program misread an accepted file, or None if it read the file correctly."""
    try:
        expected = strict.READERS[os.path.splitext(path)[1]](data)
    except Exception as error:  # a strict reading may fail in any way
        return "accepted, though a strict reading says: %s: %s" % (type(error).__name__, str(error)[:200])
    if expected is None:
        return None
    wrong = [
        "%s is %s, expected %s" % (key, answer.get(key), value)
        for key, value in expected.items()
        if not near(value, answer.get(key))
    ]
    return "; ".join(wrong) or None


class Campaign:
    def __init__(self, program, folder, keep):
        self.reader, self.folder, self.keep = Reader(program, folder), folder, keep
        self.count = {"files": 0, "crashes": 0, "over_20s": 0, "over_2GB": 0, "silently_wrong": 0}
        self.accepted, self.longest_s, self.refused = 0, 0.0, {}

    def note(self, row, path, why):
        self.count[row] += 1
        os.makedirs(self.keep, exist_ok=True)
        kept = os.path.join(self.keep, "%s-%d-%s" % (row, self.count["files"], os.path.basename(path)))
        source = os.path.dirname(path) if path.endswith(".dcm") else path
        (shutil.copytree if os.path.isdir(source) else shutil.copy)(source, kept)
        print("%s: %s\n    %s" % (row, kept, why), flush=True)

    def give(self, name, data, is_valid=None, folder=None):
        """Gives one file to the program `importers`; the program must accept it if `is_valid` is true, and refuse it if
        `is_valid` is false."""
        path = os.path.join(folder or self.folder, name)
        with open(path, "wb") as file:
            file.write(data)
        kind = corpus.KINDS[os.path.splitext(name)[1]]
        answer = self.reader.ask(
            "scan" if kind == "series" else kind, os.path.dirname(path) if kind == "series" else path
        )
        self.count["files"] += 1
        for text in reports(self.folder):
            self.note("crashes", path, text)
        if answer is None:
            self.note("crashes", path, "the program ended, or said nothing for %d s" % (3 * TIME_MAX_S))
        else:
            self.judge(path, data, answer, is_valid, kind)
        if not folder:
            os.remove(path)

    def judge(self, path, data, answer, is_valid, kind):
        self.longest_s = max(self.longest_s, answer["seconds"])
        self.accepted += answer["ok"]
        if answer["seconds"] > TIME_MAX_S:
            self.note("over_20s", path, "%.1f s" % answer["seconds"])
        if answer["is_over"]:
            self.note("over_2GB", path, "%d MiB" % answer["MiB"])
        if answer["ok"] and is_valid is False:
            self.note("silently_wrong", path, "accepted: %s" % answer)
        elif not answer["ok"] and is_valid:
            self.note("silently_wrong", path, "refused, though it is valid: %s" % answer["message"])
        elif answer["ok"] and kind != "series":
            why = disagreement(path, data, answer)
            if why:
                self.note("silently_wrong", path, why)
        elif not answer["ok"] and os.path.dirname(path) not in answer["message"] and kind != "toml":
            self.note("silently_wrong", path, "the message names no file: %s" % answer["message"])


def texts():
    """Returns the shipped TOML files."""
    paths = sorted(glob.glob(os.path.join(ROOT, "shared", "examples", "**", "*.toml"), recursive=True))
    for path in paths:
        with open(path, "rb") as file:
            yield os.path.basename(path), file.read()


def run(program, files, seed, keep):
    draw = corpus.generator(seed)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "seeds", folder], check=True, timeout=120)
        valid = {"mesh": corpus.seeds(), "toml": list(texts()), "scan": [], "line": [], "series": []}
        for path in sorted(glob.glob(os.path.join(folder, "seed*")) + glob.glob(os.path.join(folder, "series", "*"))):
            with open(path, "rb") as file:
                kind = "line" if path.endswith("_line.obj") else corpus.KINDS[os.path.splitext(path)[1]]
                valid[kind].append((os.path.basename(path), file.read()))
        valid["line"] = [row for row in valid["line"] if not row[0].endswith(".obj")]
        work, series = os.path.join(folder, "work"), os.path.join(folder, "series")
        os.mkdir(work)
        campaign = Campaign(program, work, keep)
        try:
            for kind, seeds in valid.items():
                for name, data in seeds if kind != "series" else []:
                    campaign.give(name, data, True)
            for name, data in corpus.by_hand():
                campaign.give(name, data, False)
            # The shares of the kinds: meshes have five formats.
            shares = ["mesh"] * 8 + ["toml"] * 3 + ["scan"] * 5 + ["line"] * 4 + ["series"]
            while campaign.count["files"] < files:
                kind = shares[campaign.count["files"] % len(shares)]
                name, data = draw.choice(valid[kind])
                if kind == "series":
                    campaign.give(name, corpus.mutated(data, draw), None, series)
                    with open(os.path.join(series, name), "wb") as file:
                        file.write(data)
                else:
                    campaign.give(name, corpus.mutated(data, draw))
        finally:
            campaign.reader.stop()
    return campaign


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/bin/importers")
    parser.add_argument("--files", type=int, default=3600)
    parser.add_argument("--seed", type=int, default=20)
    parser.add_argument("--keep", default="out/importers", help="folder for files that broke something")
    parser.add_argument("-o", "--output", help="the table (tab-separated)")
    options = parser.parse_args()
    began = time.monotonic()
    campaign = run(options.program, options.files, options.seed, options.keep)
    rows = "".join("importers.%s\t%d\n" % row for row in campaign.count.items())
    print(
        "%s%d accepted, longest %.1f s, %d MiB at most, %.0f s in all, seed %d"
        % (
            rows,
            campaign.accepted,
            campaign.longest_s,
            campaign.reader.MiB_before,
            time.monotonic() - began,
            options.seed,
        )
    )
    if options.output:
        os.makedirs(os.path.dirname(options.output) or ".", exist_ok=True)
        with open(options.output, "w", encoding="utf-8") as file:
            file.write(rows)
    return 1 if any(value for row, value in campaign.count.items() if row != "files") else 0


if __name__ == "__main__":
    sys.exit(main())
