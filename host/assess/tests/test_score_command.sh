#!/bin/sh
# Tests `cournand score` as a user calls it: a session that is assessed while it runs, with and without pictures, and
# its recording give the same assessment and the same page, byte for byte; mistakes are refused before the first tick.
programs="cournand bake"
. "$(dirname "$0")/../../../tools/check/tool.sh"
. "$here/../../app/tests/artery.sh"
line="--tool shared/examples/instruments/coronary_014.toml --tool shared/examples/instruments/balloon_3x20.toml
      --tool shared/examples/instruments/guide_ntr_6f.toml"
vessels="--vessel target=artery --vessel ostium=artery"

write_artery 60
cat >"$work/a.session" <<'SESSION'
begin wire inserted 20 mm
begin catheter inserted 5 mm
begin guide inserted 3 mm
table y 60 mm
field 20 cm
advance wire 20 mm at 20 mm/s
fluoro on rate 3.75 p/s
advance wire until inserted 100 mm at 40 mm/s
advance catheter until inserted 68 mm at 60 mm/s
inject 1 ml at 3 ml/s
inflate to 8 bar at 8 bar/s
wait 0.3 s
deflate at 16 bar/s
fluoro off
cine on
wait 0.5 s
cine off
wait 0.2 s
SESSION
"$BUILD/bin/bake" "$work/scene.toml" -o "$work/a.scene" --points 1000 --poses 0 >"$work/said" 2>&1

run() { # run NAME WORDS...
    name=$1
    shift
    "$tool" run --quiet --scene "$work/a.scene" $line --session "$work/a.session" --plan angioplasty $vessels \
        --record "$work/$name.rec" --json "$work/$name.json" --score "$work/$name.html" "$@" >"$work/said" 2>&1
}
run plain && run filmed --png "$work/a.png" --size 64 && cmp "$work/plain.json" "$work/filmed.json" >>"$work/said" &&
    cmp "$work/plain.html" "$work/filmed.html" >>"$work/said"
report "a session is assessed alike with and without pictures" $?

"$tool" score "$work/plain.rec" --plan angioplasty $vessels --json "$work/s.json" --html "$work/s.html" \
    >"$work/said" 2>&1 && cmp "$work/plain.html" "$work/s.html" >>"$work/said" &&
    python3 - "$work/plain.json" "$work/s.json" >>"$work/said" 2>&1 <<'PY'
import json, sys
run, later = (json.load(open(path)) for path in sys.argv[1:])
assert run["assessment"] == later
kinds = [error["kind"] for error in later["errors"]]
assert "moved_without_xray" in kinds and "empty_run" in kinds, kinds
weights = [error["weight"] for error in later["errors"]]
assert weights == sorted(weights, reverse=True)
parts = {part["name"]: part["share"] for part in later["score"]["parts"]}
assert parts["errors"] < 1 and 0 < later["score"]["percent"] < 100, parts
marks = {metric["name"]: metric["points"] for metric in later["metrics"]}
assert marks == {metric["name"]: metric["points"] for metric in run["score"]["metrics"]}
assert later["tools"][0]["tip_path_mm"] > 70 and later["tools"][0]["sparc"] < -1
steps = later["phases"][3]["steps"]
assert later["phases"][3]["end_tick"] and steps[0]["done_tick"], later["phases"][3]
PY
report "a recording gives the assessment and the page of its session" $?

"$tool" score "$work/plain.rec" >"$work/said" 2>&1 && grep -q "^error  *moderate .*without X-ray" "$work/said" &&
    grep -q "of 100$" "$work/said"
report "without a plan the recording is scored by the standard one, errors first" $?

head -c $(($(wc -c <"$work/plain.rec") * 2 / 3)) "$work/plain.rec" >"$work/cut.rec"
"$tool" score "$work/cut.rec" --plan angioplasty $vessels >"$work/said" 2>&1 && grep -q "was cut off" "$work/said"
report "a recording that was cut off is scored up to its end, which is said" $?

refuses "an unknown plan is refused with a suggestion" 1 "did you mean 'angioplasty'" score "$work/plain.rec" \
    --plan angioplastie
refuses "an unknown vessel is refused with a suggestion" 1 "did you mean 'artery'" score "$work/plain.rec" \
    --plan navigation --vessel target=artrey
refuses "a vessel without a name is refused" 1 "write NAME=VESSEL" score "$work/plain.rec" --plan navigation \
    --vessel artery
printf 'format = 1\nname = "bad"\n[[error]]\nname = "a"\nwhen = "x-ray onn"\nseverity = "serious"\nsource = "own"\n' \
    >"$work/bad.toml"
refuses "a plan with a mistake is refused with its place" 1 "bad.toml:5:15: .*found 'onn'" score "$work/plain.rec" \
    --plan "$work/bad.toml"
refuses "a page in a folder that does not exist is refused" 1 "No such file" score "$work/plain.rec" \
    --html "$work/none/s.html"
refuses "a page over its own recording is a usage error" 2 "plain.rec" score "$work/plain.rec" --html "$work/plain.rec"
refuses "a session without a script is assessed later" 2 "assessed from its recording" run --free-run 1 \
    --plan navigation $line
refuses "unknown hands are refused" 1 "did you mean 'novice'" run $line --session "$work/a.session" --hands novic:3
refuses "hands without a seed are refused" 1 "such as expert:7" run $line --session "$work/a.session" --hands expert

"$tool" run --quiet --scene "$work/a.scene" $line --session "$work/a.session" --hands novice:3 \
    --record "$work/n1.rec" >"$work/said" 2>&1
"$tool" run --quiet --scene "$work/a.scene" $line --session "$work/a.session" --hands novice:3 \
    --record "$work/n2.rec" >"$work/said" 2>&1
"$tool" run --quiet --scene "$work/a.scene" $line --session "$work/a.session" --hands novice:4 \
    --record "$work/n3.rec" >"$work/said" 2>&1
cmp "$work/n1.rec" "$work/n2.rec" && ! cmp -s "$work/n1.rec" "$work/n3.rec"
report "the same hands and seed give the same session, another seed another one" $?
echo "1..$number"
exit $failed
