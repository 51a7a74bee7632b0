#!/usr/bin/env bash
# Tests the suite as a person uses it, with real events of keys and mouse under a virtual display, and with a gamepad
# that umockdev plays: from the start screen to a session, its debrief and its replay; drags, buttons and pedals.
set -u
. "$(dirname "$0")/../../app/tests/program.sh"
. "$(dirname "$0")/../../app/tests/display.sh"
. "$(dirname "$0")/controls.sh"
export XDG_STATE_HOME="$work/state" program work
wire=shared/examples/instruments/amplatz_super_stiff.toml
size="--width 1280 --height 720 --size 128"
export wire size

# --- start, session, debrief, replay: by keys alone ---
cat >"$work/start.sh" <<'SH'
"$program" view --start $size --layout "$work/layout" >"$work/said" 2>&1 &
window=$!
shows "practice 3" && focus || { stuck; exit 1; }
keys key Next              # Page Down: the second page of cards
shows "card 10" && lacks "card 1" || exit 1
keys key Prior
shows "card 1" && lacks "card 10" || exit 1
move_to "card 2"; reads story "First push" || exit 1
keys key c # free space
shows "row 1" && shows "no patient" || exit 1
recording_begins || exit 1
keys keydown space keydown Up; ticks_pass "$recording" 3 || stuck; keys keyup space keyup Up
keys key Escape
shows replay || exit 1     # the debrief's button
keys key 1
shows scrub || exit 1
keys key Right key d
click scrub
keys key Escape
shows again || exit 1      # back in the debrief
keys key Escape
shows "card 1" || exit 1
keys key Escape
wait $window
SH
timeout 300 bash "$work/start.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
result $code "two keys lead from the start screen to pictures, and Esc back through debrief, replay and start"
"$program" replay "$work"/state/cournand/*.rec --verify >"$log" 2>&1 && "$program" info "$work"/state/cournand/*.rec |
    grep -Eq "commands to the room [1-9]"
result $? "the session of a card is kept and replays bit for bit"

# --- the mouse ---
cat >"$work/mouse.sh" <<'SH'
"$program" view --instrument "$wire" $size --no-help-panel --record "$work/mouse.rec" --json "$work/mouse.json" \
    --layout "$work/layout" >"$work/said" 2>&1 &
window=$!
shows "row 1" && focus && ticks_pass "$work/mouse.rec" 1 || { stuck; exit 1; }
move_to "row 1"
keys mousedown 1
for _ in 1 2 3 4 5 6 7 8 9 10; do keys mousemove_relative 10 0; sleep 0.05; done
ticks_pass "$work/mouse.rec" 1
# The release, the way to the next control and its click may all lie between two frames.
keys mouseup 1 mousemove --window "$(window_id)" $(place LAO) click 1; ticks_pass "$work/mouse.rec" 1
move_to fluoro; keys mousedown 1; ticks_pass "$work/mouse.rec" 3; keys mouseup 1
move_to "live picture"; keys click 4; ticks_pass "$work/mouse.rec" 2
keys key Escape
wait $window
SH
timeout 300 bash "$work/mouse.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
result $code "a session by mouse ends with exit code 0"
python3 - "$work/mouse.json" >"$log" 2>&1 <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
moved_mm = report["tools"][0]["inserted_mm"] - 20
print(moved_mm, report["room"]["total"])
# The row was dragged by 100 pixels, which are 125 units of 0.5 mm at this size; the wheel adds 2 mm.
assert 45 < moved_mm < 75, moved_mm
assert report["room"]["total"]["pulses"] > 5
PY
result $? "a drag of a device's row and the wheel push the device, and a held button is a pedal"
"$program" replay "$work/mouse.rec" --verify >"$log" 2>&1
result $? "what the mouse did replays bit for bit"

# --- a gamepad ---
cat >"$work/pad.sh" <<'SH'
pad=$work/pad
host/suite/tests/gamepad.py "$pad"
umockdev-run --device $pad.umockdev --ioctl /dev/input/event5=$pad.ioctl \
    --evemu-events /dev/input/event5=$pad.evemu -- \
    "$program" view --instrument "$wire" $size --no-help-panel --record "$work/pad.rec" --json "$work/pad.json" \
    >"$work/said" 2>&1 &
window=$!
ticks_pass "$work/pad.rec" 4 || { stuck; exit 1; }
focus && keys key Escape
wait $window
SH
timeout 300 bash "$work/pad.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
python3 - "$work/pad.json" >>"$log" 2>&1 <<'PY' && [ $code = 0 ]
import json, sys
report = json.load(open(sys.argv[1]))
print(report["tools"][0]["inserted_mm"], report["room"]["total"])
assert report["tools"][0]["inserted_mm"] > 30 and report["room"]["total"]["pulses"] > 5
PY
result $? "a gamepad's stick pushes the device, and its trigger is the pedal of fluoroscopy"
"$program" replay "$work/pad.rec" --verify >"$log" 2>&1
result $? "what the gamepad did replays bit for bit"

# --- another size ---
# The letters are drawn anew for every size of the window, so a window that was made larger must look like one that
# opened so large.
cat >"$work/resize.sh" <<'SH'
for begin in "900 560" "1300 800"; do
    rm -f "$work/layout"
    "$program" view --start --width ${begin% *} --height ${begin#* } --layout "$work/layout" \
        --screenshot "$work/from_${begin% *}.png" >"$work/said" 2>&1 &
    window=$!
    shows "card 1" && focus || { stuck; exit 1; }
    keys mousemove 2 2
    keys windowsize "$(window_id)" 1300 800
    until [ "$(place "practice 1" | cut -d' ' -f1)" -gt 1000 ] 2>/dev/null; do
        kill -0 $window 2>/dev/null || exit 1
        sleep 0.05
    done
    sleep 0.5
    keys key Escape
    wait $window || exit 1
done
cmp "$work/from_900.png" "$work/from_1300.png"
SH
timeout 120 bash "$work/resize.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
result $code "a window that was made larger shows the same pixels as one that opened so large"

# --- what cannot be opened ---
"$program" view --replay "$work/none.rec" >"$log" 2>&1
[ $? = 1 ] && grep -q "none.rec" "$log"
result $? "a replay of a file that does not exist names the file"
"$program" view --instrument "$wire" --font "$work/none.ttf" --frames 2 --no-record >"$log" 2>&1
[ $? = 1 ] && grep -q "none.ttf.*--font" "$log"
result $? "a font that does not exist is named with the remedy"
echo "1..$number"
exit $failed
