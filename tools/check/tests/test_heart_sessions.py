#!/usr/bin/env python3
"""Tests the shipped sessions of the beating heart: each reaches the end that its script states. Medium flows without
pictures. test_heart_turns.py tests that the turns are needed.

The scene is that of `make coronary`, without the bodies that only pictures need; the scene of the angioplasty also has
its lesion.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

if __name__ == "__main__":
    with sessions.Sessions() as run:
        sessions.heart(run, run.reaches)
        run.end()
