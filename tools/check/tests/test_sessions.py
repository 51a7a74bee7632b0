#!/usr/bin/env python3
"""Tests that every shipped session in the aorta or without a scene reaches the end that its script states. The script
test_turns.py tests that a session misses its end if its tools are not turned.

The test uses the scene that ships. The other scenes are made as `make run` makes them, but without their bodies, which
only pictures need. The session of the renal angioplasty has its own scene, which contains a lesion. The
script test_heart_sessions.py runs the sessions in the heart, and test_long_sessions.py (`make test-lab`) runs the long
sessions. The program hil_tests/test_pci.cpp runs the short angioplasties.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

if __name__ == "__main__":
    with sessions.Sessions() as run:
        scene = sessions.aorta(run, run.reaches)
        for start in (scene, run.scene("aorta", "renal_ostium"), run.scene("phantom"), run.scene("access")):
            run.starts(start)
        run.end()
