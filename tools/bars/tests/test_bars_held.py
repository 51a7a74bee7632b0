#!/usr/bin/env python3
"""Checks every bar (limit) on a value that is equal on all machines of one architecture: instructions, sizes, hashes,
physics (docs/bars.md). Prints TAP."""

import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "tools", "check"))
import sessions  # noqa: E402

os.chdir(ROOT)
with sessions.Sessions() as made:
    # test_shipped.py tests that this scene has the bytes of the one that the tools make.
    scene = sessions.unpack_shipped(made.folder)
    command = ["tools/bars/bars.py", "--build", sessions.BUILD, "--jobs", "1", "--tap", "--scene", scene]
    sys.exit(subprocess.run(command, check=False).returncode)
