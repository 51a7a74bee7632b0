#!/usr/bin/env python3
"""Tests that each shipped session in the beating heart reaches the end that its script states. The test lets contrast
medium flow in the sessions, but makes no pictures. The script test_turns.py tests that a session fails if its tools are
not turned.

The sessions use the scene of `make coronary` with a lesion in the LAD, but without its bodies, which only pictures
need. The lesion lies beyond the ostia, where the first two sessions end.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

if __name__ == "__main__":
    with sessions.Sessions() as run:
        run.starts(sessions.heart(run, run.reaches))
        run.end()
