#!/bin/sh
# A session does not depend on its outputs: sixteen combinations (picture, film, score, DICOM) give one
# report, byte for byte. The session has everything that pictures once owned: medium, a stent, a lesion that
# yields, fluoroscopy that is kept, a cine and a DSA run, dose.
programs="cournand bake"
. "$(dirname "$0")/../../../tools/check/tool.sh"
. "$here/artery.sh"
line="--tool shared/examples/instruments/coronary_014.toml --tool shared/examples/instruments/balloon_3x20.toml
      --tool shared/examples/instruments/guide_ntr_6f.toml --stent shared/examples/stents/coronary_3_0x18.toml"

write_artery 50
cat >"$work/all.session" <<'SESSION'
begin wire inserted 20 mm
begin catheter inserted 5 mm
begin guide inserted 3 mm
follow tip
field 10 cm
fluoro on rate 7.5 p/s
advance wire until inserted 100 mm at 100 mm/s
advance catheter until inserted 70 mm at 60 mm/s
fluoro off
store fluoro 2 s
inject 2 ml at 3 ml/s
cine on
wait 0.4 s
cine off
inflate to 8 bar at 20 bar/s
wait 0.6 s
deflate at 40 bar/s
wait 0.5 s
dsa on
inject 1 ml at 3 ml/s
wait 0.7 s
dsa off
wait 33 ms
SESSION

"$BUILD/bin/bake" "$work/scene.toml" -o "$work/a.scene" --points 1000 --poses 0 >"$work/said" 2>&1 &&
    "$tool" run --scene "$work/a.scene" $line --session "$work/all.session" --json "$work/alone.json" \
    >"$work/said" 2>&1 &&
    python3 - "$work/alone.json" >>"$work/said" 2>&1 <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
room = report["room"]
assert [run["kind"] for run in room["runs"]] == ["fluoroscopy", "cine", "dsa"], room["runs"]
assert [run["frames"] for run in room["runs"]] == [15, 6, 3], room["runs"]
assert room["total"]["pulses"] > 20 and room["total"]["kap_Gy_cm2"] > 0
assert report["contrast"]["injected_ml"] > 2.9 and report["contact"]["impulse_N_s"] > 0
assert report["stents"][0]["stage"] == "deployed", report["stents"]
assert report["lesions"][0]["after"]["stenosis_diameter_pct"] < 10, report["lesions"]
assert report["score"]["percent"] is not None and not report["refused"]
PY
report "a report alone has dose, runs, medium, stent, lesion and score" $?

different=""
for outputs in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do
    asked="--size $((64 + outputs % 3 * 16)) --fps $((15 - outputs % 4))"
    [ $((outputs & 1)) = 0 ] || asked="$asked --png $work/o.png"
    [ $((outputs & 2)) = 0 ] || asked="$asked --mp4 $work/o.mp4"
    [ $((outputs & 4)) = 0 ] || asked="$asked --score $work/o.html --record $work/o.rec"
    [ $((outputs & 8)) = 0 ] || asked="$asked --dicom $work/dicom$outputs"
    "$tool" run --scene "$work/a.scene" $line --session "$work/all.session" $asked --json "$work/o.json" \
        >"$work/said" 2>&1 &&
        cmp "$work/alone.json" "$work/o.json" >>"$work/said" 2>&1 || { different="$asked" && break; }
done
[ -z "$different" ] || echo "with $different" >>"$work/said"
[ -z "$different" ]
report "fifteen more combinations of outputs, sizes and rates give the same report, byte for byte" $?

# This session has commands between two looks, a stent that is loaded as the balloon leaves the patient, and a
# pedal that is down at the end.
cat >"$work/odd.session" <<'SESSION'
begin wire inserted 20 mm
begin catheter inserted 8 mm
begin guide inserted 3 mm
load stent
wait 50 ms
withdraw catheter 3.001 mm at 20 mm/s
load stent
inject 5 ml at 3 ml/s
wait 213 ms
inject stop
wait 87 ms
inject 0.3 ml at 3 ml/s
cine on
wait 777 ms
SESSION
odd="$line --stent shared/examples/stents/coronary_3_0x18.toml --session $work/odd.session"
"$tool" run --scene "$work/a.scene" $odd --json "$work/odd.json" --record "$work/odd.rec" >"$work/said" 2>&1
[ $? -le 1 ] && python3 - "$work/odd.json" >>"$work/said" 2>&1 <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
print(report["contrast"], report["room"]["runs"])
# 213 ms and 100 ms at 3 ml/s, less the part that waits for a look
assert 0.85 < report["contrast"]["injected_ml"] < 0.95
assert report["room"]["runs"] == [{"number": 1, "kind": "cine", "frames": 12}]
PY
report "an injection ends when it is stopped, and a run whose pedal is still down is told of" $?

different=""
for asked in "--png $work/o.png --fps 1" "--png $work/o.png --fps 49" "--mp4 $work/o.mp4 --fps 60" \
    "--png16 $work/o16.png --style vcsim3 --fps 17"; do
    "$tool" run --scene "$work/a.scene" $odd --size 64 $asked --json "$work/o.json" >"$work/said" 2>&1
    cmp "$work/odd.json" "$work/o.json" >>"$work/said" 2>&1 || { different="$asked" && break; }
done
[ -z "$different" ] || echo "with $different" >>"$work/said"
[ -z "$different" ]
report "nor does it depend on the rate of pictures what is done between two of them" $?

for asked in "" "--png $work/o.png --size 64 --fps 49"; do
    "$tool" replay "$work/odd.rec" --verify $asked --json "$work/o.json" >"$work/said" 2>&1
    python3 - "$work/odd.json" "$work/o.json" >>"$work/said" 2>&1 <<'PY' || different="replay $asked"
import json, sys
run, replay = (json.load(open(path)) for path in sys.argv[1:])
for report in (run, replay):  # values that only a script has
    for key in ("steered", "expected", "failures", "script_lines_given_up"):
        report.pop(key)
    for tool in report["tools"]:
        tool.pop("grip")
different = [key for key in run if run[key] != replay[key]]
assert run.keys() == replay.keys() and not different, [(key, run[key], replay[key]) for key in different]
PY
done
[ -z "$different" ]
report "its replay says the same, with pictures and without" $?

"$tool" run --scene "$work/a.scene" $line --session "$work/all.session" --timing "$work/t.json" --quiet \
    >"$work/said" 2>&1 &&
    grep -q '"wall_clock_s"' "$work/t.json" && ! grep -q wall_clock "$work/alone.json"
report "what the machine took stands in a file of its own" $?

printf 'withdraw 60 mm at 100 mm/s\n' >"$work/end.session"
"$tool" run "$work/end.session" --tool shared/examples/instruments/j_wire.toml >"$work/said" 2>&1 &&
    grep -q "^notice .*end of its length.*nothing is wrong" "$work/said" && ! grep -q CORE_INSERT_END "$work/said"
report the_end_of_a_tools_length_is_a_notice_and_no_fault $?
echo "1..$number"
exit $failed
