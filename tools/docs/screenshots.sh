#!/usr/bin/env bash
# Writes screenshots of the window in three sizes into a folder, on a virtual display: the suite with and without
# help, replay, and the screens of a case.
# usage: screenshots.sh PROGRAM SCENE FOLDER
set -euo pipefail
program=$(realpath "$1") scene=$2 folder=$3
instruments=shared/examples/instruments
mkdir -p "$folder"
command -v Xvfb >/dev/null || { echo "screenshots: Xvfb is missing; install xvfb" >&2; exit 1; }
exec {number}< <(exec Xvfb -displayfd 1 -screen 0 3840x2160x24 -nolisten tcp -noreset 2>/dev/null)
server=$!
work=$(mktemp -d)
trap 'kill $server 2>/dev/null; rm -rf "$work"' EXIT
read -r -t 30 -u "$number" DISPLAY || { echo "screenshots: Xvfb did not start" >&2; exit 1; }
export DISPLAY=:$DISPLAY XDG_STATE_HOME=$work
shot() { # name, options
    local name=$1
    shift
    "$program" view --width "$width" --height "$height" --frames 90 --screenshot "$folder/${name}_$width.png" "$@" \
        >"$work/said" 2>&1 || { cat "$work/said" >&2; exit 1; }
    echo "written $folder/${name}_$width.png"
}
line=(--tool $instruments/coronary_014.toml --tool $instruments/balloon_3x20.toml --tool $instruments/guide_jl4_6f.toml)
for size in 1280x720 1920x1080 3840x2160; do
    width=${size%x*} height=${size#*x}
    shot suite --scene "$scene" --tool $instruments/j_wire.toml --fluoro --no-help-panel --record "$work/one.rec"
    shot devices "${line[@]}" --fluoro --no-help-panel --no-record
    shot help --scene "$scene" --tool $instruments/j_wire.toml --fluoro --no-record
    shot replay --replay "$work/one.rec"
    mv "$work/one.rec" "$work/old.rec"
    tools/docs/case_screens.sh "$program" "$width" "$height" "$work"
    for screen in start prep case debrief expert; do mv "$work/$screen.png" "$folder/${screen}_$width.png"; done
done
