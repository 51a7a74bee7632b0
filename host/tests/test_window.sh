#!/usr/bin/env bash
# The window under a virtual display: picture on the screen, keys into the recording, no display without a crash.
set -u
cd "$(dirname "$0")/../.." || exit 1
program="${BUILD:-build}/bin/seldinger"
wire=shared/examples/instruments/amplatz_super_stiff.toml
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
number=0 failed=0
result() { # status, name
    number=$((number + 1))
    if [ "$1" = 0 ]; then echo "ok $number - $2"; else echo "not ok $number - $2"; failed=1; fi
}

[ -x "$program" ] || make -s PACKAGES=skip "$program" >&2

env -u DISPLAY -u WAYLAND_DISPLAY "$program" view --instrument "$wire" >"$work/none" 2>&1
[ $? = 1 ] && grep -q "no display" "$work/none"
result $? "without a display it says so and ends with 1"

xvfb-run -a "$program" view --instrument "$wire" --fluoro --frames 20 --screenshot "$work/a.png" \
    --record "$work/a.rec" >"$work/log" 2>&1 && [ "$(head -c 4 "$work/a.png" | tail -c 3)" = PNG ]
result $? "20 screens give a screenshot and exit code 0"

"$program" replay "$work/a.rec" --verify >"$work/log" 2>&1
result $? "what the window recorded replays bit for bit"

for run in b c; do
    xvfb-run -a "$program" view --instrument "$wire" --fluoro --frames 20 --no-help-panel \
        --screenshot "$work/$run.png" >"$work/log" 2>&1
done
cmp -s "$work/b.png" "$work/c.png" && ! cmp -s "$work/a.png" "$work/b.png"
result $? "the same screens again are the same pixels, and the help panel shows"

# A person: push for a second, turn the C-arm, end.
cat >"$work/keys.sh" <<'EOF'
"$program" view --instrument "$wire" --record "$work/live.rec" >"$work/live" 2>&1 &
window=$!
for _ in $(seq 100); do xdotool search --name Seldinger >/dev/null 2>&1 && break; sleep 0.1; done
sleep 0.5
xdotool search --name Seldinger windowfocus >/dev/null 2>&1
xdotool keydown Up keydown space; sleep 1; xdotool keyup Up keyup space key d key h
sleep 0.3
xdotool key Escape
wait "$window"
EOF
export program wire work
timeout 60 xvfb-run -a bash "$work/keys.sh"
result $? "Escape ends it with exit code 0"
"$program" replay "$work/live.rec" --verify >"$work/log" 2>&1
result $? "keys are recorded and replay bit for bit"
# Pedal down, pedal up, C-arm: with the first view at least four.
"$program" info "$work/live.rec" 2>&1 | grep -Eq "view changes ([4-9]|[1-9][0-9])"
result $? "pedal and C-arm keys reach the recording"
echo "1..$number"
exit $failed
