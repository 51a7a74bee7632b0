#!/usr/bin/env python3
"""Tests that a whole angioplasty of the left anterior descending artery can be done by hand in at most 60 actions. Real
keys and clicks lead from the start screen to the score, with wire, bare balloon, stent and two cine runs. The session
takes about five minutes in real time, or longer on a busy machine, so the test has the label `hours`.
"""

import os
import subprocess
import sys
import tempfile

BUILD = os.environ.get("BUILD", "build")
ACTIONS_MAX = 60
SCORE_LEAST = 50  # of 100; measured: 54 to 96

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        recording = os.path.join(folder, "pci.rec")
        played = subprocess.run(
            ["tools/bench/pci_by_hand.py", "--build", BUILD, "--record", recording],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        for line in played.stdout.splitlines():
            print("#", line)
        last = (played.stdout.splitlines() or [""])[-1].split("\t")
        is_played = played.returncode == 0 and last[0] == "suite.pci_actions"
        actions = int(last[1]) if is_played else 0
        score = int(last[3].split("score=")[1].split()[0]) if is_played else 0
        replay = [BUILD + "/bin/cournand", "replay", recording, "--verify"]
        verified = subprocess.run(replay, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    results = [
        (is_played and 0 < actions <= ACTIONS_MAX, f"a whole angioplasty by hand takes at most {ACTIONS_MAX} actions"),
        (score >= SCORE_LEAST, f"its score is at least {SCORE_LEAST} of 100"),
        (verified.returncode == 0, "what the hand did replays bit for bit"),
    ]
    for number, (is_good, name) in enumerate(results, 1):
        print("ok" if is_good else "not ok", number, "-", name)
    print(f"1..{len(results)}")
    sys.exit(0 if all(is_good for is_good, _ in results) else 1)
