#!/usr/bin/env bash
# Plays a case in the window as a trainee does, with real events of keys and mouse: start screen, preparation, session,
# debrief, replay. The marks are stored for the trainee, and equal those of the command line.
set -u
. "$(dirname "$0")/../../app/tests/program.sh"
. "$(dirname "$0")/../../app/tests/display.sh"
. "$(dirname "$0")/controls.sh"
export XDG_STATE_HOME="$work/state" XDG_DATA_HOME="$work/data" XDG_CACHE_HOME="$work/cache" program work
size="--width 1280 --height 720 --size 128 --no-help-panel"
export size

# --- by keys: three actions lead from the start screen to pictures ---
cat >"$work/keys.sh" <<'SH'
"$program" view --start $size --layout "$work/layout" >"$work/said" 2>&1 &
window=$!
shows "card 2" && focus || { stuck; exit 1; }
keys key 2                # first_push
shows ready || exit 1     # its scene is unpacked meanwhile
keys key Return
shows "row 1" || exit 1
recording_begins || exit 1
keys keydown space; ticks_pass "$recording" 2 || stuck
keys keydown Up; ticks_pass "$recording" 6 || stuck; keys keyup Up; keys keyup space
reads "tip 1" "mm inside" || exit 1 # the tooltip of the device's row
shows "side left" && cp "$work/layout" "$work/layout.case"
for _ in 1 2 3 4 5 6 7; do # every rate of fluoroscopy and of runs
    keys key p o; sleep 0.2
    cat "$work/layout" >>"$work/layout.rates"
done
keys key Escape
shows assessed || exit 1  # the recording has been replayed
shows "phase 1" && shows curves || exit 1
keys key s
click "phase 1"
shows scrub || exit 1
keys key x
shows "expert picture" || exit 1 # its run is recorded meanwhile
keys key Escape
shows again || exit 1
keys key Escape
shows "card 1" || exit 1
keys key Escape
wait $window
SH
timeout 300 bash "$work/keys.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
result $code "three keys lead from the start screen to the pictures of a case, and its debrief to the replay"
python3 - "$work/layout.case" "$work/layout.rates" >"$log" 2>&1 <<'PY'
import sys
rows = {}
for line in open(sys.argv[2]):
    assert "does not fit" not in line, line
for line in open(sys.argv[1]):
    name, *place = line.rstrip("\n").split("\t")
    rows[name] = [float(word) for word in place[:4]] + [place[4] if len(place) > 4 else ""]
    assert "does not fit" not in rows[name][4], line
x, y, width, height, _ = rows["live picture"]
for side in ("side left", "side right"):
    left, _, wide, _, letter = rows[side]
    print(side, letter, left, wide, "beside", x, width)
    assert letter in ("R", "L") and x < left and left + wide < x + width
PY
result $? "the letters of the patient's sides lie in the live monitor, and every label fits its button"
"$program" records list --json >"$work/list.json" 2>"$log"
result $? "the session is in the records"
recording=$(ls "$work"/state/cournand/*.rec)
"$program" case score first_push "$recording" --json "$work/marks.json" >"$log" 2>&1
python3 - "$work/list.json" "$work/marks.json" "${recording%.rec}" >>"$log" 2>&1 <<'PY'
import json, os, sys
stored = json.load(open(sys.argv[1]))
session = (stored if isinstance(stored, list) else stored["sessions"])[0]
print(session)
marks = json.load(open(sys.argv[2]))["case"]
page = open(sys.argv[3] + ".html").read()
figures = json.load(open(sys.argv[3] + ".json"))
assert session["trainee"] == "guest", session
assert "first_push" in json.dumps(session)
assert figures["case"] == marks, (figures["case"], marks)
assert figures["assessment"]["errors"] is not None and "<html" in page
# The weights of the case itself: a wire alone has no result.
weights = [part["weight"] for part in figures["assessment"]["score"]["parts"]]
assert weights == [60, 30, 0, 10], weights
assert 0 < marks["score"] < 100, marks["score"]
PY
result $? "the marks of the debrief are those of the command line, and its page and figures are saved"
"$program" replay "$work"/cache/cournand/experts/*.rec --verify >"$log" 2>&1
result $? "the run of the expert beside the replay is kept in the cache, and replays bit for bit"
"$program" records check >"$log" 2>&1
result $? "the stored session has its recording"

# --- by mouse: a trainee with a name, and a line that does not fit the case ---
cat >"$work/mouse.sh" <<'SH'
"$program" view --start $size --layout "$work/layout" >"$work/said" 2>&1 &
window=$!
shows trainee && focus || { stuck; exit 1; }
click trainee; reads trainee "typing:" || exit 1
keys type otter; reads trainee otter || exit 1
keys key Return
click "card 2"
shows ready || exit 1
click "device 2"; lacks ready || exit 1  # a second wire does not go through the first one
click "device 2"; shows ready || exit 1
keys key 2; lacks ready || exit 1        # the same by its key
keys key 2; shows ready || exit 1
click "start case"
shows "row 1" || exit 1
recording_begins || exit 1
ticks_pass "$recording" 1
click hint
keys key Escape
shows assessed || exit 1
keys key Escape
shows "card 1" || exit 1
keys key Escape
wait $window
SH
timeout 300 bash "$work/mouse.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
result $code "the mouse chooses a card and the devices; a device that does not fit keeps the session from beginning"
"$program" records list --trainees >"$log" 2>&1 && grep -q otter "$log"
result $? "the session is stored for the trainee who was named"
echo "1..$number"
exit $failed
