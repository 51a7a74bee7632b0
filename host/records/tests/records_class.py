"""Makes a class of invented trainees for the tests of `cournand records`, and runs the program's commands."""

import json
import math
import os
import random
import subprocess

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
PROGRAM = os.path.join(ROOT, os.environ.get("BUILD") or "build", "bin/cournand")


def sessions(people=7, each=14, seed=3):
    """The trainees t0, t1 ... get faster and make fewer errors from session to session; the expert plays three
    times."""
    rng = random.Random(seed)
    made = []
    for person in range(people):
        for number in range(each - person % 3):
            made.append(session("t%d" % person, number, 1.0 + 0.15 * person, rng, person))
    made += [session("expert", 40 + number, 0.02, rng, 20, by_expert=True) for number in range(3)]
    return {"format": 1, "sessions": made}


def session(trainee, number, slowness, rng, hour, by_expert=False):
    left = slowness * math.exp(-(number % 40) / 4.0)
    errors = [
        {"tick": 1000 * (i + 1), "kind": "moved_without_xray", "severity": 3, "text": "wire"}
        for i in range(round(5.0 * left))
    ]
    score = max(0.0, min(100.0, 90.0 - 45.0 * left + rng.uniform(-5.0, 5.0)))
    return {
        "trainee": trainee, "by_expert": by_expert, "case": "lad_pci", "case_version": "1", "core_version": "15",
        "program_version": "0.1.0", "started_at": "2026-10-%02dT%02d:00:00.000Z" % (1 + number % 28, hour),
        "duration_s": round(600.0 + 900.0 * left + rng.uniform(-60.0, 60.0), 2), "seed": number,
        "passed": score >= 80.0, "score": {"total": score, "of": 100.0, "parts": []},
        "metrics": [{"name": "fluoroscopy_min", "value": 6.0 + 14.0 * left + rng.uniform(-1.0, 1.0), "unit": "min"}],
        "events": errors,
    }  # fmt: skip


class Desk:
    """Holds a file of records in a folder, and runs commands on the file."""

    def __init__(self, folder):
        self.folder = folder
        self.file = os.path.join(folder, "records.db")
        self.environment = {k: v for k, v in os.environ.items() if k not in ("COURNAND_RECORDS", "XDG_DATA_HOME")}
        self.environment["HOME"] = folder

    def run(self, *words, code=0, place=None):
        """Returns (standard output, standard error), and checks that the exit code is `code`."""
        command = [PROGRAM, "records", *words]
        if "ship" not in words or place:
            command += ["--records", place or self.file]
        done = subprocess.run(
            command, cwd=self.folder, env=self.environment, capture_output=True, text=True, stdin=subprocess.DEVNULL
        )
        if done.returncode != code:
            raise AssertionError("%s: exit code %d instead of %d: %s" % (words, done.returncode, code, done.stderr))
        return done.stdout, done.stderr

    def json(self, *words, **more):
        return json.loads(self.run(*words, "--json", **more)[0])

    def write(self, name, content):
        path = os.path.join(self.folder, name)
        with open(path, "w") as file:
            file.write(content if isinstance(content, str) else json.dumps(content))
        return path

    def fill(self, **more):
        self.run("import", self.write("class.json", sessions(**more)))


def check(claims):
    """Runs test functions, each with a folder and records of its own, and prints TAP; a function fails if it raises
    AssertionError."""
    import sys
    import tempfile
    import traceback

    failed = 0
    print("1..%d" % len(claims))
    for number, claim in enumerate(claims, 1):
        with tempfile.TemporaryDirectory(prefix="cournand-records-") as folder:
            try:
                claim(Desk(folder))
                print("ok %d - %s" % (number, claim.__name__))
            except (AssertionError, KeyError, ValueError, OSError) as error:
                failed += 1
                print("not ok %d - %s" % (number, claim.__name__))
                print("# %s" % "\n# ".join(traceback.format_exception(error))[-1500:].replace("\n", "\n# "))
    sys.exit(1 if failed else 0)
