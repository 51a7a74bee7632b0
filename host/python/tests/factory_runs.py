"""Runs the factory of labelled pictures for its tests: makes small data sets, kills runs, and compares folders byte by
byte."""

import contextlib
import hashlib
import io
import os
import random
import signal
import subprocess
import sys
import time

from cournand.factory import cli

SMALL = (
    *("--frames", "10", "--shard-frames", "4", "--block-frames", "2", "--size", "64", "--seed", "28"),
    *("--tools", "j_wire,beacon_5f,rosen+balloon_6x20@renal_6_0x18"),
)
FORMATS = ("--formats", "webdataset,coco,dicom")
WORDS = (sys.executable, "-m", "cournand.factory")
KEPT = "parts"  # holds locks and what a killed run has left


def factory(*words):
    """Runs a command of the factory in this process, and returns its exit code and its output."""
    printed, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
        code = cli.main(words)
    return code, printed.getvalue(), errors.getvalue()


def made(folder, *words):
    """Makes a data set, and returns whether this succeeded; prints the errors."""
    code, _, errors = factory(*words, "--out", folder, "--quiet")
    print("".join("# %s\n" % line for line in errors.splitlines()), end="")
    return code == 0


def run_command(*words):
    """Runs a command of the factory in a separate process, which its worker processes need, and returns its exit
    code."""
    ended = subprocess.run([*WORDS, *words], capture_output=True, text=True, check=False)
    print("".join("# %s\n" % line for line in ended.stderr.splitlines()), end="")
    return ended.returncode


def contents(folder):
    """Returns the hash of each file of a data set, by the file's path."""
    found = {}
    for at, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if name != KEPT]
        for name in names:
            path = os.path.join(at, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = hashlib.sha256(file.read()).hexdigest()
    return found


def equal(first, second):
    """Returns whether two data sets contain the same files with the same bytes; prints the first difference."""
    a, b = contents(first), contents(second)
    for path in sorted(set(a) | set(b)):
        if a.get(path) != b.get(path):
            print("# %s differs, or is in one of them alone" % path)
            return False
    return len(a) > 5


def written(folder):
    """Returns the number of bytes that runs have written into a folder so far."""
    total = 0
    for at, _, names in os.walk(folder):
        for name in names:
            with contextlib.suppress(FileNotFoundError):  # a file that gets its final name now
                total += os.path.getsize(os.path.join(at, name))
    return total


def killed(folder, words, size, seconds):
    """Starts a run; after it has written this many bytes, kills the run and its workers, as a machine failure would.
    Returns whether the run was still working when it was killed."""
    run = subprocess.Popen(
        [*WORDS, *words, "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    while run.poll() is None and written(folder) < size:
        time.sleep(0.005)
    time.sleep(seconds)
    is_at_work = run.poll() is None
    if is_at_work:
        os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    return is_at_work


def survives_kills(folder, whole, words, kills, seed, workers=1):
    """Kills a run at random moments, continues it each time, and compares the data set with the complete data set
    `whole`. The moments depend on the number of written bytes, so they do not depend on the speed of the machine."""
    draw, hit, work = random.Random(seed), 0, ["--workers", str(workers)]
    shard = sum(os.path.getsize(os.path.join(at, name)) for at, _, names in os.walk(whole) for name in names)
    shard /= 2 * len(os.listdir(os.path.join(whole, "shards")))  # every file has two names
    for _ in range(kills):
        has_begun = os.path.exists(os.path.join(folder, "plan.json"))
        command = ["resume", folder] if has_begun else [*words, "--out", folder]
        size = written(folder) + draw.uniform(0.0, 1.0) * shard
        hit += killed(folder, [*command, *work], size, draw.uniform(0.0, 0.2))
    code = run_command("resume", folder, "--quiet", *work)
    print("# %d of %d runs were killed, at moments of the seed %d" % (hit, kills, seed))
    return code == 0 and hit >= kills * 2 // 3 and equal(folder, whole)
