#!/usr/bin/env python3
"""Tests that every shipped session in the aorta or without a scene reaches the end that its script states.
test_turns.py tests that a session misses this end if its tools are not turned.

The test makes anatomy and scene as `make run` does, but without the bodies that only pictures need. The resulting scene
file equals the scene file of `make run` byte for byte. The session of the renal angioplasty has its own scene, which
contains a lesion. test_heart_sessions.py runs the sessions in the heart, and hil_tests/test_pci.cpp runs the short
angioplasties.
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
        scene = sessions.aorta(run, run.reaches)
        for name, changes in CHANGES.items():
            run.changed("sessions/demo", scene, "j_wire", name, changes)
        for start in (scene, run.scene("aorta", "renal_ostium"), run.scene("phantom"), run.scene("access")):
            run.starts(start)
        run.end()
