#!/usr/bin/env python3
"""Tests the shipped sessions of the beating heart: each reaches the end that its script states, and without its turns
it does not reach this end. Medium flows without pictures.

The scene is that of `make coronary`, without the bodies that only pictures need; the scene of the angioplasty also has
its lesion.
"""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sessions  # noqa: E402

if __name__ == "__main__":
    with sessions.Sessions() as run:
        scene = run.scene("heart")
        run.session("sessions/coronary", scene, ["j_wire", "guide_jl3_6f"])
        run.session("sessions/coronary_right", scene, ["j_wire", "guide_ntr_6f"])
        run.session(
            "sessions/pci_lad",
            run.scene("heart", "lad_middle"),
            ["coronary_014", "balloon_3x20", "guide_jl3_6f"],
            "coronary_3_0x18",
        )
        run.end()
