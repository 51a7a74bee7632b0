#!/bin/sh
# Tests a lesion from text to healed vessel on the command line: it is baked, opened by a balloon in a
# session, and appears in the session's report, its pictures and its polygons. The artery of 3 mm is 60 %
# narrowed; the balloon opens it fully, and it recoils by 0.3 of that: 60 % x 0.3 = 18 % remain.
programs="cournand bake"
. "$(dirname "$0")/../../../tools/check/tool.sh"
. "$here/artery.sh"
line="--tool shared/examples/instruments/coronary_014.toml --tool shared/examples/instruments/balloon_3x20.toml
      --tool shared/examples/instruments/guide_ntr_6f.toml"

write_artery 60 "eccentricity = 0.3" "calcified_deg = 90"
cat >"$work/open.session" <<'SESSION'
begin wire inserted 20 mm
begin catheter inserted 5 mm
begin guide inserted 3 mm
table y 60 mm
field 10 cm
advance wire until inserted 100 mm at 100 mm/s
advance catheter until inserted 70 mm at 60 mm/s
fluoro on rate 3.75 p/s
inject 2 ml at 3 ml/s
wait 0.2 s
inflate to 8 bar at 20 bar/s
wait 0.6 s
deflate at 40 bar/s
wait 0.6 s
inject 1 ml at 3 ml/s
wait 0.2 s
SESSION

"$BUILD/bin/bake" "$work/scene.toml" -o "$work/a.scene" --points 1000 --poses 0 >"$work/said" 2>&1 &&
    "$tool" run --scene "$work/a.scene" $line --session "$work/open.session" --record "$work/a.rec" \
    --json "$work/a.json" \
        --png "$work/a.png" --score "$work/a.html" --size 64 >"$work/said" 2>&1 &&
    python3 - "$work/a.json" >"$work/said" 2>&1 <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
before, after = report["lesions"][0], report["lesions"][0]["after"]
print(before, report["contrast"])
assert abs(before["stenosis_diameter_pct"] - 60) < 0.1 and abs(before["minimum_diameter_mm"] - 1.2) < 0.01
assert abs(after["stenosis_diameter_pct"] - 18) < 0.5 and abs(after["stenosis_area_pct"] - (100 - 82 ** 2 / 100)) < 1
assert before["ffr"] < 0.95 < after["ffr"] < 1 and after["rest_drop_mmHg"] < 0.1 * before["rest_drop_mmHg"]
assert report["contrast"]["iodine_error"] < 1e-9 and report["contrast"]["injected_ml"] > 2
PY
report "a report has a lesion before its balloon and after it, and no iodine is lost" $?

"$tool" replay "$work/a.rec" --verify >"$work/said" 2>&1
report "the session replays bit for bit" $?

"$tool" replay "$work/a.rec" --json "$work/b.json" --score "$work/b.html" --size 64 >"$work/said" 2>&1 &&
    python3 - "$work/a.json" "$work/b.json" >>"$work/said" 2>&1 <<'PY'
import json, sys
run, replay = (json.load(open(path)) for path in sys.argv[1:])
for report in (run, replay):  # values that only a script has
    for key in ("steered", "expected", "failures", "script_lines_given_up"):
        report.pop(key)
    for tool in report["tools"]:
        tool.pop("grip")
different = [key for key in run if run[key] != replay[key]]
assert run.keys() == replay.keys() and not different, [(key, run[key], replay[key]) for key in different]
assert run["score"]["percent"] == replay["score"]["percent"] is not None and run["contact"]["impulse_N_s"] > 0
PY
[ $? = 0 ] && grep -qi "score" "$work/b.html"
report "its recording is scored as the session was, with the same report" $?

"$tool" replay "$work/a.rec" --json "$work/c.json" --from 1 >"$work/said" 2>&1
[ $? = 2 ] && grep -q "whole session" "$work/said" && [ ! -e "$work/c.json" ]
report "a report of a part of a recording is wrong usage" $?

printf 'begin inserted 20 mm\ninflate to 2 bar\n' >"$work/none.session"
"$tool" run --scene "$work/a.scene" --tool shared/examples/instruments/coronary_014.toml \
    --session "$work/none.session" >"$work/said" 2>&1
[ $? = 1 ] && grep -q "none.session:2: NO BALLOON" "$work/said"
report "an inflation without a balloon is refused with its line before the session" $?

printf 'begin wire inserted 20 mm\nbegin catheter inserted 10 mm\ninject 2 ml at 3 ml/s through catheter\nwait 1 s\n' \
    >"$work/tight.session"
"$tool" run --scene "$work/a.scene" $line --session "$work/tight.session" >"$work/said" 2>&1
[ $? = 1 ] && grep -q "tight.session:3: 3 ml/s THROUGH .* NEEDS [78][0-9]* psi" "$work/said"
report "an injection that a lumen does not pass is refused with the pressure that it would need" $?

"$tool" surface "$work/a.rec" --stages -o "$work/a.obj" --png "$work/walls.png" >"$work/stages" 2>&1 &&
    grep -q '^positioned .* s$' "$work/stages" && grep -q '^inflated .* s$' "$work/stages" &&
    grep -q '^released .* s$' "$work/stages" &&
    python3 - "$work/a.obj" >"$work/said" 2>&1 <<'PY'
import sys
objects, faces = {}, {}
for line in open(sys.argv[1]):
    word = line.split()
    if word[0] == "o":
        name = word[1]
        objects[name], faces[name] = [], 0
    elif word[0] == "v":
        objects[name].append([float(x) for x in word[1:]])
    elif word[0] == "f":
        faces[name] += 1
names = sorted({n.split("_")[0] for n in objects})
print({n: len(v) for n, v in objects.items()})
width = []
for n in names:  # of the lumen's vertices in the throat, across
    x = [v[0] for v in objects[n + "_lumen"] if abs(v[1] - 60) < 0.25]
    width.append(max(x) - min(x))
    assert len(objects[n + "_lumen"]) == len(objects[names[0] + "_lumen"])
    assert faces[n + "_lumen"] == faces[names[0] + "_lumen"]
    assert len(objects[n + "_plaque_calcium"]) > 500 and all(32 < v[1] < 88 for v in objects[n + "_lumen"])
print(width)
for got, wanted in zip(width, (1.2, 3.0, 2.46)):
    assert abs(got - wanted) < 0.08, (got, wanted)
assert all(n + "_balloon" in objects for n in names)
PY
result=$?
head -c 24 "$work/walls.png" | od -A n -t u1 | tr -s ' \n' ' ' | grep -q ' 0 0 5 160 0 0 1 224 *$' # 1440 x 480
[ $? = 0 ] && [ $result = 0 ]
report "its polygons go from stenosed to the balloon's width and stay healthier" $?

refuses "a moment behind the end is refused" 1 "is not between its begin and its end" surface "$work/a.rec" --at 1000 \
    -o "$work/b.obj"
printf '%s\n' 'begin wire inserted 20 mm' 'begin catheter inserted 10 mm' 'inflate to 2 bar at 20 bar/s' 'wait 0.2 s' \
    'deflate at 20 bar/s' 'wait 0.6 s' 'inflate to 4 bar at 20 bar/s' 'wait 0.2 s' 'deflate at 20 bar/s' 'wait 0.6 s' \
    >"$work/two.session"
"$tool" run --scene "$work/a.scene" $line --session "$work/two.session" --record "$work/two.rec" >"$work/said" 2>&1 &&
    "$tool" surface "$work/two.rec" --stages -o "$work/two.obj" >"$work/said" 2>&1 &&
    awk '$1 == "inflated" { exit !($2 < 0.5) }' "$work/said" && grep -q '^inflated' "$work/said"
report "the stages are those of the first inflation, also if a later one is higher" $?

refuses "no moment is a usage error" 2 "name moments with --at, or --stages" surface "$work/a.rec" -o "$work/b.obj"
refuses "a lesion that is not there is refused" 1 "but plaque" surface "$work/a.rec" --at 0 --lesion lad \
    -o "$work/b.obj"
refuses "a surface over its own recording is a usage error" 2 "a.rec" surface "$work/a.rec" --at 0 -o "$work/a.rec"
[ ! -e "$work/b.obj" ]
report "what is refused has written nothing" $?
echo "1..$number"
exit $failed
