#!/usr/bin/env python3
"""Tests every shipped case: the session of its expert must reach all goals and get at least 90 of 100 marks. The
session of the case's clumsy beginner must get at most 60 marks. The scenes are made with all bodies, so the test takes
half an hour on one processor core.

host/app/tests/test_case.sh plays one short case in `make test`.
"""

import os
import subprocess
import sys
import tempfile

BUILD = os.environ.get("BUILD", "build")
PROGRAM = f"{BUILD}/bin/cournand"


def names():
    """Returns the names of the shipped cases."""
    done = subprocess.run([PROGRAM, "case", "list"], stdout=subprocess.PIPE, text=True, check=True)
    return [line.split()[0] for line in done.stdout.splitlines()]


if __name__ == "__main__":
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_DATA_HOME"] = folder  # no cases of the user
        os.environ.setdefault("XDG_CACHE_HOME", folder)
        cases = names()
        for number, name in enumerate(cases, 1):
            done = subprocess.run(
                [PROGRAM, "case", "check", name, "--play"],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
            )
            for line in done.stdout.splitlines():
                print("#", line)
            failed += done.returncode != 0
            print(("ok" if done.returncode == 0 else "not ok"), number, "-", f"{name}_separates_expert_and_beginner")
            sys.stdout.flush()
    print(f"1..{len(cases)}")
    sys.exit(1 if failed else 0)
