# Sourced after display.sh by the tests of the suite: finds controls in the window's layout file, and clicks them.

# Where a control is: "x y" of its middle, in the window's pixels.
place() { awk -F'\t' -v name="$1" '$1 == name {printf "%d %d", $2 + $4 / 2, $3 + $5 / 2}' "$work/layout"; }
# Waits until the screen has a control; `lacks` waits until it has it no more.
shows() {
    for _ in $(seq 1200); do # 60 s
        [ -n "$(place "$1" 2>/dev/null)" ] && return 0
        sleep 0.05
    done
    echo "the window does not show '$1'"
    return 1
}
lacks() {
    for _ in $(seq 1200); do
        [ -z "$(place "$1" 2>/dev/null)" ] && return 0
        sleep 0.05
    done
    echo "the window still shows '$1'"
    return 1
}
# Waits until a control shows a text that matches a pattern, such as the length in a device's row.
reads() {
    for _ in $(seq 1200); do
        awk -F'\t' -v name="$1" '$1 == name {print $6}' "$work/layout" 2>/dev/null | grep -Eq -- "$2" && return 0
        sleep 0.05
    done
    echo "'$1' does not show '$2' but: $(awk -F'\t' -v name="$1" '$1 == name {print $6}' "$work/layout")"
    return 1
}
# Waits until the window, which is process $window, records a session. Its file, without the end that it has meanwhile,
# is then $recording.
recording_begins() {
    local part
    until part=$(ls "$work"/state/cournand/*.rec.part* 2>/dev/null); do
        kill -0 "$window" 2>/dev/null || return 1
        sleep 0.05
    done
    recording=${part%.part*}
}
window_id() { timeout 10 xdotool search --onlyvisible --name Cournand 2>/dev/null | tail -n 1; }
move_to() { keys mousemove --window "$(window_id)" $(place "$1"); }
click() { move_to "$1" && keys click 1; }
export -f place shows lacks reads recording_begins window_id move_to click
