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

def comes_and_goes(run, scene):
    """Tests a catheter whose tip leaves the vessels and enters them again at many moments of the looks at its pressure.
    If it entered in the very batch that a look ended, the session stopped for want of the tools' shape."""
    path, recording = f"{run.folder}/comes.session", f"{run.folder}/comes.rec"
    with open(path, "w", encoding="utf-8") as file:
        file.write("begin wire inserted 14 mm\nbegin catheter inserted 4 mm\nadvance wire 20 mm at 50 mm/s\n")
        for wait_ms in range(1, 41):
            file.write("withdraw catheter 7 mm at 250 mm/s\nwait %d ms\nadvance catheter 7 mm at 250 mm/s\n" % wait_ms)
    words = ["run", "--quiet", "--scene", scene, "--session", path, "--record", recording]
    for tool in ("bentson", "pigtail_5f"):
        words += ["--tool", f"shared/examples/instruments/{tool}.toml"]
    code, said = run.call("cournand", *words)
    run.result(code == 0, "a_catheter_that_comes_and_goes_does_not_stop_the_session", said)
    code, said = run.call("cournand", "replay", recording, "--verify")
    run.result(code == 0, "and_its_recording_replays", said)


if __name__ == "__main__":
    with sessions.Sessions() as run:
        scene = sessions.aorta(run, run.reaches)
        for start in (scene, run.scene("aorta", "renal_ostium"), run.scene("phantom"), run.scene("access")):
            run.starts(start)
        comes_and_goes(run, scene)
        run.end()
