#!/usr/bin/env bash
# Plays a case in the window by real keys, and writes pictures of its screens: start, prep, case, debrief, expert. Needs
# a display (DISPLAY) without a window manager, and xdotool.
# usage: case_screens.sh PROGRAM WIDTH HEIGHT FOLDER [SCREEN...]
set -euo pipefail
program=$(realpath "$1") width=$2 height=$3 folder=$4
shift 4
[ $# -gt 0 ] || set -- start prep case debrief expert
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_STATE_HOME=$work XDG_DATA_HOME=$work
shows() { # the window's layout file has this control
    for _ in $(seq 3000); do
        grep -q "^$1	" "$work/layout" 2>/dev/null && return 0
        sleep 0.1
    done
    echo "case_screens: the window does not show '$1'" >&2
    return 1
}
go_to() { # from the start screen, as far as this screen
    shows "card 2"
    xdotool windowfocus --sync "$(xdotool search --onlyvisible --name '^Cournand$' | tail -n 1)"
    xdotool mousemove "$width" "$height" # the pointer rests on nothing
    [ "$1" != start ] || return 0
    xdotool key 2
    shows ready
    [ "$1" != prep ] || return 0
    xdotool key Return
    shows "row 1"
    xdotool keydown space keydown Up
    sleep 6
    [ "$1" != case ] || { xdotool keyup Up key ctrl+h; sleep 0.5; return 0; }
    xdotool keyup space # the wire goes on without X-ray, which is an error
    sleep 1
    xdotool keyup Up key Escape
    shows assessed
    [ "$1" != debrief ] || return 0
    xdotool key 1
    shows expert
    xdotool key x
    shows "expert picture"
    xdotool key Right Right Right Right
    sleep 2
}
for screen; do
    rm -f "$work/layout"
    "$program" view --start --width "$width" --height "$height" --no-help-panel --layout "$work/layout" \
        --screenshot "$work/screen.png" >"$work/said" 2>&1 &
    window=$!
    go_to "$screen" || { kill $window; cat "$work/said" >&2; exit 1; }
    sleep 1
    kill -INT $window
    wait $window || true # 1: it was interrupted
    xdotool keyup space keyup Up
    mv "$work/screen.png" "$folder/$screen.png"
    echo "written $folder/$screen.png"
done
