#!/usr/bin/env bash
# Tests the X-ray room in a whole session: every mode by script, the same pictures again from the recording,
# dose in the report.
set -u
. "$(dirname "$0")/program.sh"
wire=shared/examples/instruments/j_wire.toml

# The session is in free space with the wire alone, so that it takes only seconds.
cat >"$work/room.session" <<'EOF'
begin inserted 30 mm
follow tip
fluoro on rate 7.5 p/s
advance 30 mm at 60 mm/s
fluoro off
follow off
dsa on rate 6 f/s
wait 400 ms
advance 20 mm at 40 mm/s
dsa off
mask frames 1 to 2
shift mask right 0.5 px
roadmap from run
fluoro on rate 15 p/s
withdraw 10 mm at 40 mm/s
fluoro off
store fluoro 2 s
cine on rate 30 f/s
wait 300 ms
cine off
review run 1
wait 300 ms
review run 1 frame 3
wait 100 ms
EOF
"$program" run --instrument "$wire" --session "$work/room.session" --size 128 --record "$work/a.rec" \
    --png "$work/a.png" --json "$work/a.json" >"$work/log" 2>&1
result $? "a script uses every mode of the room"

"$program" replay "$work/a.rec" --verify --size 128 --png "$work/b.png" >"$work/replay" 2>&1 &&
    cmp "$work/a.png" "$work/b.png"
result $? "its recording replays to the same picture, byte for byte"

python3 - "$work/a.json" <<'EOF'
import json, sys
room = json.load(open(sys.argv[1]))["room"]
kinds = [one["kind"] for one in room["irradiations"]]
assert kinds == ["fluoroscopy", "dsa", "fluoroscopy", "cine"], kinds
assert [run["kind"] for run in room["runs"]] == ["dsa", "fluoroscopy", "cine"], room["runs"]
for name in ("kap_Gy_cm2", "reference_air_kerma_mGy", "pulses"):
    total, parts = room["total"][name], sum(one[name] for one in room["irradiations"])
    assert total > 0 and abs(total - parts) <= 1e-3 * total, (name, total, parts)
assert room["runs"][0]["frames"] == room["irradiations"][1]["pulses"]
# Fluoroscopy time is pedal time: 0.5 s + 0.2 s of ramp, and 0.25 s + 0.2 s.
assert abs(room["fluoroscopy_min"] * 60 - 1.15) < 0.01, room["fluoroscopy_min"]
EOF
result $? "dose in the report: the total is the sum over the presses within 0.1 %, runs have a frame per pulse"

grep -q "^dose  *[0-9.]* mGy reference air kerma, [0-9.]* Gy cm2" "$work/log"
result $? "and stands at the end of the run"

says() { # script, expected
    printf '%s\n' "$1" >"$work/bad.session"
    "$program" run --instrument "$wire" --session "$work/bad.session" >"$work/bad" 2>&1
    [ $? = 1 ] && grep -qF "$2" "$work/bad"
}
says "view spidr" "bad.session:1:6: unknown view 'spidr', did you mean 'spider'?" &&
    says "fluoro rate 10 p/s" "bad.session:1:13: no such rate; there are 3.75, 7.5, 15, 30 per second" &&
    says "collimate width 2 %" "opening is out of range" &&
    says "mask frames 3 to 2" "the last frame of a mask comes after its first" &&
    says "c-arm SID 2 m" "SID is out of range"
result $? "mistakes are answered with their place and what there is"
echo "1..$number"
exit $failed
