#!/usr/bin/env python3
"""Tests that the shipped sessions in the beating heart miss expectations of their scripts if the tools are not turned.
Medium flows without pictures.

The sessions use the scene of `make coronary` with a lesion in the LAD, without the bodies that
only pictures need. The lesion lies beyond the ostia, where the first two sessions end.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

if __name__ == "__main__":
    with sessions.Sessions() as run:
        sessions.heart(run, run.misses)
        run.end()
