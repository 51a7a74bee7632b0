#!/usr/bin/env python3
"""Tests that each shipped session with turns fails to reach its expected end without these turns. The scripts
test_sessions.py and test_heart_sessions.py test that the unchanged sessions reach their ends.

Contrast medium flows in the sessions, but no pictures are made. The scenes are without their bodies, which only
pictures need.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

if __name__ == "__main__":
    with sessions.Sessions() as run:
        sessions.aorta(run, run.misses)
        sessions.heart(run, run.misses)
        sessions.angioplasty(run, run.misses)
        run.end()
