#!/usr/bin/env python3
"""Tests that the shipped sessions of the beating heart do not reach their ends without their turns. Medium flows
without pictures.

The scene is that of `make coronary`, without the bodies that only pictures need; the scene of the angioplasty also has
its lesion.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

if __name__ == "__main__":
    with sessions.Sessions() as run:
        sessions.heart(run, run.misses)
        run.end()
