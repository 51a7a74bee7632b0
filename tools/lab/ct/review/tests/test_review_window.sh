#!/usr/bin/env bash
# Makes a scene of a CT in the window as a person does, with real events of keys and mouse: the scan without a label
# map, a click, another run, a look at the finished patient, and the session.
set -u
. "$(dirname "$0")/../../../../../host/app/tests/program.sh"
. "$(dirname "$0")/../../../../../host/app/tests/display.sh"
. "$(dirname "$0")/../../../../../host/suite/tests/controls.sh"
export XDG_STATE_HOME="$work/state" XDG_DATA_HOME="$work/data" XDG_CACHE_HOME="$work/cache" program work
python3 "$(dirname "$0")/phantom.py" "$work/Doe_John.nii" # the name of a patient must go nowhere
export patient="$work/Doe_John_patient" # nor the name of the folder

# The window is `ct patient --window`; the words of `cournand patient` are tested in test_cli_patient.cpp.
cat >"$work/new.sh" <<'SH'
"$build/bin/ct" patient "$work/Doe_John.nii" -o "$patient" --window --layout "$work/layout" \
    --screenshot "$work/shot.png" >"$work/said" 2>&1 &
window=$!
shows axial && focus || { stuck; exit 1; }
reads "step scene" done || exit 1           # the command begins by itself
reads progress "ready" || exit 1
click coronal; click "branch 1"; keys key a # the cross jumps into the branch
reads clicks "1 clicks" || exit 1
reads progress "make the scene again" || exit 1
keys key r
reads progress "Working" || exit 1
reads progress "ready" || exit 1
keys key Escape
wait $window
SH
export build
timeout 500 bash "$work/new.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log" 2>/dev/null
result $code "the window makes a scene without a label map, takes a click, and makes it again"
grep -q 'kind = "artery"' "$patient/clicks.toml" 2>>"$log"
result $? "the click is kept in the folder"
"$program" info "$patient/patient.scene" >"$log" 2>&1 && grep -q "aorta" "$patient/tree.csv" 2>>"$log"
result $? "the scene has the aorta as a branch"
! grep -rqa "Doe_John" "$patient" 2>>"$log"
result $? "no file of the folder holds the name of the scan's file"

rm -f "$work/layout"
cat >"$work/review.sh" <<'SH'
"$program" patient review "$patient" >"$work/said" 2>&1 &
window=$!
focus || { stuck; exit 1; }
sleep 1 # there is no layout file here: the first frame is on the screen when the window has the keyboard
keys key p
for _ in $(seq 600); do # 30 s: the session's window keeps a recording
    ls "$work"/state/cournand/*.rec* >/dev/null 2>&1 && break
    sleep 0.05
done
focus && keys key Escape
wait $window
SH
timeout 200 bash "$work/review.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log" 2>/dev/null
ls "$work"/state/cournand/*.rec >>"$log" 2>&1 || code=1
result $code "a finished patient is opened without its scan, and its session is played"
echo "1..$number"
exit $failed
