#!/usr/bin/env python3
"""Tests the factory of labelled pictures with tests that take too long for `make test`: a run that is killed 20 times,
a run that loses its workers, and Ray on this machine. All runs must write the same bytes as an undisturbed run. Prints
TAP. The test has the label `hours`, because Ray is a large download and each killed run must start a new process."""

import os
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import prepare  # noqa: E402

prepare.enter(os.path.abspath(__file__), "requirements-ray.txt")

import factory_runs as runs  # noqa: E402

sys.path.insert(0, os.path.join(prepare.ROOT, "tools", "check"))
import tap  # noqa: E402

FOLDER = tempfile.TemporaryDirectory()
WHOLE = os.path.join(FOLDER.name, "whole")
WORDS = [word if word != "10" else "100" for word in runs.SMALL] + list(
    runs.FORMATS
)  # 25 shards, about one for each kill


def folder(name):
    return os.path.join(FOLDER.name, name)


def twenty_kills_lose_and_double_nothing():
    good = runs.made(WHOLE, *WORDS)
    return good and runs.survives_kills(folder("killed"), WHOLE, WORDS, 20, seed=3, workers=2)


def children(parent):
    """Returns the child processes of a process."""
    with open("/proc/%d/task/%d/children" % (parent, parent), encoding="ascii") as file:
        return [int(word) for word in file.read().split()]


def a_killed_worker_is_replaced():
    run = subprocess.Popen(
        [*runs.WORDS, *WORDS, "--out", folder("lost"), "--workers", "2"], stderr=subprocess.PIPE, text=True
    )
    shards, is_killed = folder("lost/shards"), False
    while run.poll() is None and not is_killed:
        if os.path.isdir(shards) and os.listdir(shards):
            for worker in children(run.pid)[-1:]:
                os.kill(worker, signal.SIGKILL)
                is_killed = True
    errors = run.communicate()[1]
    return is_killed and run.returncode == 0 and "a worker was killed" in errors and runs.equal(WHOLE, folder("lost"))


def ray_writes_the_bytes_of_one_process():
    words = [*WORDS, "--out", folder("ray"), "--executor", "ray", "--workers", "2", "--quiet"]
    return runs.run_command(*words) == 0 and runs.equal(WHOLE, folder("ray"))


if __name__ == "__main__":
    tap.run([twenty_kills_lose_and_double_nothing, a_killed_worker_is_replaced, ray_writes_the_bytes_of_one_process])
