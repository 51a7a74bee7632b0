#!/usr/bin/env python3
"""Tests that the whole angioplasty in the beating heart reaches the end that its script states. The test also checks
that the demo reaches its end with slightly different instruments. The scripts test_sessions.py and
test_heart_sessions.py run the other shipped sessions. The long sessions take minutes, so they belong to `make
test-lab`.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

# These changes are small, because no measurement gives the quantities to the per cent. The course of the session
# changes, and its end must not.
CHANGES = {
    "a_tenth_more_friction": {"value = 0.1,": "value = 0.11,", "value = 0.12,": "value = 0.132,"},
    "a_stiffer_shaft": {"2.9e-4,": "3.1e-4,"},
    "a_softer_shaft_with_less_friction": {
        "2.9e-4,": "2.7e-4,",
        "value = 0.1,": "value = 0.09,",
        "value = 0.12,": "value = 0.108,",
    },
}

if __name__ == "__main__":
    with sessions.Sessions() as run:
        scene = sessions.unpack_shipped(run.folder)
        for name, changes in CHANGES.items():
            run.changed("sessions/demo", scene, "j_wire", name, changes)
        sessions.angioplasty(run, run.reaches)
        run.end()
