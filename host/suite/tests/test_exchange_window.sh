#!/usr/bin/env bash
# Exchanges devices in the window as a person does, with real events of keys and mouse under a virtual display: a
# guiding catheter is withdrawn and exchanged, another one is loaded over the wire, and what is not possible is told.
set -u
. "$(dirname "$0")/../../app/tests/program.sh"
. "$(dirname "$0")/../../app/tests/display.sh"
. "$(dirname "$0")/controls.sh"
export program work
size="--width 1280 --height 720 --size 128 --no-help-panel"
devices="--tool amplatz_super_stiff --tool guide_jl4_6f --tool guide_jr4_6f"
export size devices

# --- by keys: the guide is still in the patient; it is withdrawn, and another one takes its place ---
cat >"$work/keys.sh" <<'SH'
"$program" view $devices --line 1,guide_jl4_6f --inserted 60 --inserted 30 $size --record "$work/keys.rec" \
    --json "$work/keys.json" --layout "$work/layout" >"$work/said" 2>&1 &
window=$!
shows "row 2" && focus && ticks_pass "$work/keys.rec" 1 || { stuck; exit 1; }
keys key 2
keys key slash
reads "table 3" "to load" || exit 1
keys key Insert
reads notice "NO EXCHANGE.*still in the patient" || exit 1
keys keydown Down; reads "row 2" " -[1-9] mm" || exit 1; keys keyup Down
keys key Insert
reads "row 2" "Guide JR4" || exit 1
reads "table 2" "to load" || exit 1 # what was exchanged is the next one to load
keys key Delete
reads "row 2" "^free" || exit 1
keys key Escape
wait $window
SH
timeout 300 bash "$work/keys.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
result $code "keys withdraw a guide, exchange it for another one, and take that off the line"
"$program" replay "$work/keys.rec" --verify >"$log" 2>&1
result $? "the exchanges replay bit for bit"
python3 - "$work/keys.json" >"$log" 2>&1 <<'PY'
import json, sys
names = [tool["name"] for tool in json.load(open(sys.argv[1]))["tools"]]
print(names)
assert names[1] == "nothing", names
PY
result $? "the report has the tools that are on the line at the end"

# --- by mouse: a catheter is loaded on a free position, and taken off ---
cat >"$work/mouse.sh" <<'SH'
"$program" view $devices --line amplatz_super_stiff,nothing $size --no-record --layout "$work/layout" \
    >"$work/said" 2>&1 &
window=$!
shows "row 2" && focus || { stuck; exit 1; }
click "row 2"
click "table 3"
reads "table 3" "to load" || exit 1
click load
reads "row 2" "Guide JR4" || exit 1
click "take off"
reads "row 2" "^free" || exit 1
keys key Escape
wait $window
SH
timeout 300 bash "$work/mouse.sh" >"$log" 2>&1
code=$?
cat "$work/said" >>"$log"
result $code "the mouse loads a guide of the device table on a free position, and takes it off"

# --- without a window: the option --line names the line of a free run, and replaces that of a script ---
names='import json, sys; print(",".join(tool["name"] for tool in json.load(open(sys.argv[1]))["tools"]))'
"$program" run --free-run 0.2 $devices --line 1,nothing,guide_jr4_6f --json "$work/free.json" --quiet >"$log" 2>&1 &&
    python3 -c "$names" "$work/free.json" >>"$log" && grep -q "Stiff 0.035 in,nothing,Guide JR4 6F" "$log"
result $? "a free run begins with the tools that --line names"
printf 'begin with 1 2\nwait 0.1 s\n' >"$work/a.session"
"$program" run "$work/a.session" $devices --line 1,guide_jr4_6f --json "$work/a.json" --quiet >"$log" 2>&1 &&
    python3 -c "$names" "$work/a.json" >>"$log" && grep -q "Stiff 0.035 in,Guide JR4 6F" "$log"
result $? "the option --line replaces what a script begins with"
"$program" view $devices --tool pigtail_5f --frames 2 --no-record >"$log" 2>&1
[ $? = 2 ] && grep -q -- "4 tools are named: say with --line" "$log"
result $? "more tools than a line holds need the option --line"
echo "1..$number"
exit $failed
