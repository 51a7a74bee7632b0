#!/bin/sh
# Tests the program `vcsim3`: `make thesis` in short form (128 elements of 3 mm in the shipped phantom, two modes), the
# same bytes for any number of threads, and messages for bad command lines. Prints TAP.
programs="vcsim3 anatomy bake"
. "$(dirname "$0")/../../../check/tool.sh"

"$BUILD/bin/anatomy" phantom -o "$work/phantom" --no-bodies --quiet >/dev/null &&
    "$BUILD/bin/bake" "$work/phantom/scene.toml" -o "$work/phantom.scene" --points 1000 --poses 0 >/dev/null 2>&1
report "the phantom is made" $?

figures() { # figures FOLDER ARGUMENTS...
    folder=$1
    shift
    "$tool" figures --scene "$work/phantom.scene" -o "$work/$folder" --elements 128 --element-mm 3 --speed-mm-s 100 \
        --modes penalty local5 --no-stability "$@" >"$work/$folder.said" 2>&1
}

figures one
result=$?
report "the short form of all figures is made and its order holds" $result
[ $result = 0 ] || sed 's/^/# /' "$work/one.said"

# Independently of the program's own check, column 2 falls from row to row, with the direct solver last.
awk -F'\t' 'NR == 1 { next } NR > 2 && !($2 < last) { bad = 1 } { last = $2; rows++ } END { exit bad || rows != 3 }' \
    "$work/one/figure_5_11.tsv"
report "penalty > 5 local > direct in figure_5_11.tsv" $?

for name in figure_5_11 figure_5_12 figure_5_13 figure_5_14; do
    [ "$(head -c 4 "$work/one/$name.png" | tail -c 3)" = PNG ] && grep -q "$name.png" "$work/one/index.html"
    report "$name.png is a picture on the page" $?
done

python3 - "$work/one" <<'END'
import json, sys
folder = sys.argv[1]
data = json.load(open(folder + "/thesis.json", encoding="utf-8"))
assert [row["mode"] for row in data["compression"]] == ["1 Penalty", "5 Local", "Direct"], data["compression"]
assert data["order_faults"] == [] and len(data["presets"]) == 9
rows = [line.split("\t") for line in open(folder + "/figure_5_12.tsv", encoding="utf-8").read().splitlines()[1:]]
ends = [row for row in rows if row[0] == "Direct"]
assert len(ends) in (129, 130), len(ends)  # 128 elements, and perhaps one that is just leaving the inserter
assert {row[5] for row in rows} == {"0", "1"}
times = [line.split("\t") for line in open(folder + "/figure_5_14.tsv", encoding="utf-8").read().splitlines()]
assert [row[6] for row in times[1:]] == ["4", "4", "1"], times
END
report "the tables hold what they should" $?

figures two --threads 2 --no-times
for name in figure_5_11.tsv figure_5_12.tsv; do
    cmp -s "$work/one/$name" "$work/two/$name"
    report "$name is the same from two threads" $?
done

"$tool" presets >"$work/presets.tsv"
[ "$(wc -l <"$work/presets.tsv")" = 10 ] && grep -q '^amplatz' "$work/presets.tsv"
report "nine presets are listed" $?

"$tool" run local5 --scene "$work/phantom.scene" --elements 128 --element-mm 3 --speed-mm-s 100 >"$work/run.tsv" \
    2>"$work/said" &&
    [ "$(tail -1 "$work/run.tsv")" = "$(grep '^5 Local' "$work/one/figure_5_11.tsv")" ]
report "run gives the line of the figure" $?

"$tool" figures --scene "$work/phantom.scene" -o "$work/three" --no-stability >"$work/said" 2>&1 &
process=$!
sleep 1
kill -TERM $process
wait $process
[ $? = 1 ] && grep -q interrupted "$work/said" && [ ! -e "$work/three/index.html" ]
report "a wish to stop ends with 1 and without a page" $?

refuses "a missing subcommand is a usage error" 2 "subcommand is required"
refuses "an unknown mode is a usage error that lists the modes" 2 "local10000" run local0
refuses "an unknown preset is a usage error that says where they are" 2 "vcsim3 presets" run local5 --preset lunderquist
refuses "too many elements are a usage error" 2 "elements" figures --elements 400
refuses "a missing scene fails and says how to make it" 1 "make thesis" run local5 --scene "$work/nowhere.scene"
head -c 5000 "$work/phantom.scene" >"$work/cut.scene"
refuses "a damaged scene fails and is named" 1 "cut.scene: is no usable scene" run direct --scene "$work/cut.scene"
refuses "states that are not there fail and are named" 1 "local5.state" steps local5 --states "$work" \
    --scene "$work/phantom.scene"
cp "$work/one/states/local5.state" "$work/local5.state"
refuses "a state of another rod is refused" 1 "does not fit" steps local5 --states "$work" --scene "$work/phantom.scene"
refuses "help shows examples" 0 "Examples" --help

echo "1..$number"
exit $failed
