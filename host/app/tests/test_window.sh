#!/usr/bin/env bash
# Tests the window under a virtual display: picture on the screen, keys into the recording, and no crash
# without a display.
set -u
. "$(dirname "$0")/program.sh"
. "$(dirname "$0")/display.sh"
export XDG_STATE_HOME="$work/kept"
wire=shared/examples/instruments/amplatz_super_stiff.toml

env -u DISPLAY -u WAYLAND_DISPLAY "$program" view --instrument "$wire" >"$work/none" 2>&1
[ $? = 1 ] && grep -q "no display" "$work/none"
result $? "without a display it says so and ends with 1"

"$program" view --instrument "$wire" --fluoro --frames 20 --screenshot "$work/a.png" \
    --record "$work/a.rec" --dicom "$work/runs" --size 128 >"$work/log" 2>&1 &&
    [ "$(head -c 4 "$work/a.png" | tail -c 3)" = PNG ]
result $? "20 screens give a screenshot and exit code 0"

"$program" replay "$work/a.rec" --verify >"$work/log" 2>&1
result $? "what the window recorded replays bit for bit"

"$program" replay "$work/a.rec" --dicom "$work/runs_again" --size 128 >"$work/log" 2>&1 &&
    [ "$(ls "$work/runs")" = run_01_fluoro.dcm ] && diff -r "$work/runs" "$work/runs_again" >>"$work/log"
result $? "the window's run is a DICOM file, and the replay writes the same bytes"

"$program" view --instrument "$wire" --dicom "$work/runs" >"$work/log" 2>&1
[ $? = 2 ] && grep -q "already holds run_01_fluoro.dcm" "$work/log"
result $? "a folder that holds runs already is wrong usage"

for run in b c; do
    "$program" view --instrument "$wire" --fluoro --frames 20 --no-help-panel \
        --screenshot "$work/$run.png" --size 128 >"$work/log" 2>&1
done
cmp -s "$work/b.png" "$work/c.png" && ! cmp -s "$work/a.png" "$work/b.png"
result $? "the same screens again are the same pixels, and the help panel shows"

"$program" view --instrument "$wire" --free-run --frames 20 --record "$work/led.rec" >"$work/log" 2>&1 &&
    "$program" replay "$work/led.rec" --verify >>"$work/log" 2>&1 && grep -q "^verified" "$work/log"
result $? "a session that the rig leads is shown, recorded and replays bit for bit"

# A session without a named recording is kept nevertheless, and prints its summary at its end.
XDG_STATE_HOME="$work/state" "$program" view --instrument "$wire" --fluoro --frames 40 --json "$work/view.json" \
    --size 128 >"$work/view" 2>&1 &&
    "$program" replay "$work"/state/cournand/*.rec --verify --json "$work/again.json" --png "$work/again.png" \
    --size 128 >"$work/log" 2>&1 &&
    grep -q "^final hash" "$work/view" && grep -q "^dose " "$work/view" &&
    grep -q "^written .*state/cournand" "$work/view" &&
    python3 - "$work/view.json" "$work/again.json" >>"$work/log" 2>&1 <<'PY'
import json, sys
view, again = (json.load(open(path)) for path in sys.argv[1:])
assert view["ticks"] > 500 and view["room"]["total"]["pulses"] > 5
for key in ("ticks", "hash", "penetration_max_mm", "room", "tip"):
    assert view[key] == again[key], (key, view[key], again[key])
PY
result $? "a session by hand is recorded without being asked, and reported as its replay is"
XDG_STATE_HOME="$work/nowhere" "$program" view --instrument "$wire" --frames 5 --no-record --size 128 \
    >"$work/log" 2>&1 && [ ! -e "$work/nowhere" ]
result $? "unless --no-record says otherwise"

# The keys of a person: push for a second or less, turn the C-arm, end.
cat >"$work/keys.sh" <<'EOF'
"$program" view --instrument "$wire" --record "$work/live.rec" >"$work/live" 2>&1 &
window=$!
ticks_pass "$work/live.rec" 1
focus || { stuck; exit 1; }
timeout 10 xdotool search --onlyvisible --class \
    "^$(sed -n 's/^StartupWMClass=//p' tools/desktop/cournand.desktop)\$" >"$work/class" 2>"$work/log"
keys keydown Up keydown space; ticks_pass "$work/live.rec" 2 || stuck; keys keyup Up keyup space key d key h
ticks_pass "$work/live.rec" 1
keys key Escape
wait "$window"
EOF
export program wire work
timeout 300 bash "$work/keys.sh"
result $? "Escape ends it with exit code 0"
[ -s "$work/class" ]
result $? "the window has the class by which a desktop finds its icon"
"$program" replay "$work/live.rec" --verify >"$work/log" 2>&1
result $? "keys are recorded and replay bit for bit"
# The recording has at least four commands: table and following at the start, pedal down, pedal up, C-arm.
"$program" info "$work/live.rec" 2>&1 | grep -Eq "commands to the room ([4-9]|[1-9][0-9])"
result $? "pedal and C-arm keys reach the recording"

# The device disappears in mid-session: the window reports it, the recording is whole up to there, and the
# exit code is not 0.
cat >"$work/gone.sh" <<'EOF'
"$program" view --instrument "$wire" --device emulator --record "$work/gone.rec" >"$work/gone" 2>&1 &
window=$!
for _ in $(seq 200); do
    emulator=$(pgrep -P "$window" qemu)
    [ -n "$emulator" ] && break
    sleep 0.1
done
ticks_pass "$work/gone.rec" 1
kill -9 $emulator
for _ in $(seq 100); do grep -q "the emulator ended" "$work/gone" && break; sleep 0.1; done
focus && keys key Escape
wait "$window"
EOF
timeout 300 bash "$work/gone.sh"
[ $? = 1 ] && grep -q "ended by a fault: the emulator ended" "$work/gone"
result $? "a device that goes away is told, and the exit code is 1"
"$program" replay "$work/gone.rec" --verify >"$work/log" 2>&1
[ $? = 1 ] && grep -q "^verified: [1-9][0-9]* ticks" "$work/log" &&
    grep -q "the recording was cut off there" "$work/log"
result $? "what was recorded until then replays bit for bit, and is said to be cut off"

# With two tools: the catheter is selected and pushed for a second or more, then the wire and the catheter
# together.
cat >"$work/two.sh" <<'EOF'
"$program" view --tool "$wire" --tool "$catheter" --inserted 60 --inserted 40 --record "$work/two.rec" \
    --screenshot "$work/two.png" >"$work/two" 2>&1 &
window=$!
ticks_pass "$work/two.rec" 1
focus || { stuck; exit 1; }
keys key 2; keys keydown Up; ticks_pass "$work/two.rec" 3 || stuck; keys keyup Up; ticks_pass "$work/two.rec" 1
keys key g; keys keydown Up; ticks_pass "$work/two.rec" 2 || stuck; keys keyup Up; ticks_pass "$work/two.rec" 1
keys key Escape
wait "$window"
EOF
export catheter=shared/examples/instruments/beacon_5f.toml
timeout 300 bash "$work/two.sh" >"$work/two_said" 2>&1
code=$?
cat "$work/two_said" >>"$work/two" 2>/dev/null
ls "$work" >>"$work/two" # a second recording: a key restarted the session
log="$work/two" result $code "two tools open, move and end with exit code 0"
"$program" replay "$work/two.rec" --verify >"$work/log" 2>&1
result $? "what the keys did to two tools replays bit for bit"
# The wire moved only with the second push, the catheter with both.
awk '/^tool/ {k = $2} /inserted/ {end[k] = $2} END {exit !(end[1] > 62 && end[2] - 40 > end[1] - 60 + 10)}' "$work/log"
result $? "the chosen tool moves alone, and both move together"

"$program" view --tool "$wire" --tool "$catheter" --inserted 1 --inserted 2 --inserted 3 >"$work/log" 2>&1
[ $? = 2 ] && grep -q "only 2 tools" "$work/log"
result $? "more lengths than tools are wrong usage"

# After Ctrl-C every written file is whole, and the exit code shows that the session did not end by itself.
cat >"$work/stop.sh" <<'EOF'
env --default-signal=INT "$program" view --instrument "$wire" --record "$work/stop.rec" >"$work/stop" 2>&1 &
window=$!
ticks_pass "$work/stop.rec" 1
kill -INT "$window"
wait "$window"
EOF
timeout 300 bash "$work/stop.sh"
code=$?
echo "exit code $code" >>"$work/stop"
[ $code = 1 ] && grep -q "interrupted" "$work/stop" && "$program" info "$work/stop.rec" | grep -q "complete"
result $? "Ctrl-C closes the recording and ends with 1"
echo "1..$number"
exit $failed
