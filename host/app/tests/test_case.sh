#!/bin/sh
# Cases are listed, checked, written and played without a window. An expert gets at least 90 of 100 marks, and a clumsy
# beginner at most 60. A scene is made once and found again, two programs may make it at once, and an interrupted
# program leaves nothing half-made. `make test-lab` plays all cases (tools/check/tests/test_cases.py).
programs="cournand anatomy bake"
. "$(dirname "$0")/../../../tools/check/tool.sh"
export XDG_CACHE_HOME="$work/cache" XDG_DATA_HOME="$work/data"
scenes=$XDG_CACHE_HOME/cournand/scenes

"$tool" case list >"$work/said" 2>&1 && [ "$(wc -l <"$work/said")" -ge 10 ] && grep -q '^first_push ' "$work/said"
report at_least_ten_cases_are_listed $?

"$tool" case list --json >"$work/list.json" 2>"$work/said" &&
    python3 - "$work/list.json" >>"$work/said" 2>&1 <<'PYTHON'
import json, sys
cases = json.load(open(sys.argv[1]))
assert len(cases) >= 10 and all(case["goals"] and case["story"] and case["aim"] for case in cases)
PYTHON
report the_list_has_its_story_and_goals_as_json $?

"$tool" case check --all >"$work/said" 2>&1
report every_shipped_case_passes_the_check $?

"$tool" case new mine >"$work/said" 2>&1 && "$tool" case check mine >>"$work/said" 2>&1 &&
    "$tool" case list 2>&1 | grep -q '^mine '
report a_new_case_passes_the_check_and_is_listed $?

refuses a_case_is_not_overwritten 1 "exists already" case new mine
refuses a_strange_name_is_refused 2 "small letters" case new ../mine
mine=$XDG_DATA_HOME/cournand/cases/mine.toml
cp "$mine" "$work/mine.toml"
printf '\n[assessment]\nplan = "navigation"\n[assessment.vessels]\ntarget = "ascending aorte"\n' >>"$mine"
refuses a_vessel_of_the_assessment_is_checked 1 "did you mean 'ascending aorta'" case check mine
cp "$work/mine.toml" "$mine"
printf '\n[assessment]\nplan = "navigation"\n[assessment.score]\nerrors = 60\n' >>"$mine"
refuses a_weight_without_a_source_is_refused 1 "source" case check mine
cp "$work/mine.toml" "$mine"
refuses a_misspelt_case_is_suggested 1 "did you mean 'first_push'" case play first_pus --script expert
refuses an_unknown_script_is_refused 1 "there is no session" case play first_push --script nobody
(unset DISPLAY WAYLAND_DISPLAY && "$tool" case play first_push >"$work/said" 2>&1; [ $? = 2 ]) &&
    grep -q -- "--script expert" "$work/said"
report without_a_display_a_script_is_proposed $?

# score FILE LEAST MOST
score() {
    python3 - "$@" >>"$work/said" 2>&1 <<'PYTHON'
import json, sys
score = json.load(open(sys.argv[1]))["case"]["score"]
print("score", score)
sys.exit(not float(sys.argv[2]) <= score <= float(sys.argv[3]))
PYTHON
}
# Both find an empty cache at the same moment.
"$tool" case play first_push --script clumsy --quiet --json "$work/clumsy.json" >"$work/clumsy.said" 2>&1 &
clumsy=$!
"$tool" case play first_push --script expert --quiet --json "$work/expert.json" \
    --record "$work/expert.rec" >"$work/said" 2>&1
[ $? = 0 ] && score "$work/expert.json" 90 100
report an_expert_reaches_the_goals $?
wait $clumsy
[ $? = 1 ] && score "$work/clumsy.json" 0 60
report a_clumsy_beginner_does_not $?
[ "$(ls "$scenes" | grep -vc lock)" = 1 ]
report two_programs_make_one_scene $?

"$tool" case score first_push "$work/expert.rec" --json "$work/again.json" >"$work/said" 2>&1 &&
    python3 - "$work/expert.json" "$work/again.json" >>"$work/said" 2>&1 <<'PYTHON'
import json, sys
first, again = (json.load(open(name))["case"] for name in sys.argv[1:])
print(first, again)
sys.exit(first != again)
PYTHON
report a_recording_gets_the_same_marks $?

"$tool" case play rings --script expert --quiet >"$work/said" 2>&1 &
play=$!
sleep 1
kill -INT $play
wait $play
code=$?
[ $code != 0 ] && [ "$(ls "$scenes" | grep -vc lock)" = 1 ] && grep -q interrupted "$work/said"
report an_interrupted_program_leaves_no_half_scene $?

XDG_CACHE_HOME=/dev/null/none
refuses a_cache_that_cannot_be_written_is_refused 1 "set XDG_CACHE_HOME" case play first_push --script expert
echo "1..$number"
exit $failed
