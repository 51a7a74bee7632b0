#!/usr/bin/env bash
# The program: what it writes, what it refuses and how, and the editor under a virtual display: clicks, undo, save,
# resume, Ctrl-C.
set -u
. "$(dirname "$0")/../../../host/app/tests/program.sh"
. host/app/tests/display.sh
program="$build/bin/centreline"

# An open tube of radius 2 mm and 30 mm along y.
python3 - "$work/tube.obj" <<'PY'
import math, sys
with open(sys.argv[1], "w") as file:
    for i in range(61):
        for j in range(32):
            a = 2 * math.pi * j / 32
            file.write("v %.6f %.6f %.6f\n" % (2 * math.cos(a), i / 2, -2 * math.sin(a)))
    v = lambda i, j: 32 * i + j % 32 + 1
    for i in range(60):
        for j in range(32):
            corners = (v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j), v(i + 1, j + 1), v(i, j + 1))
            file.write("f %d %d %d\nf %d %d %d\n" % corners)
PY
cat >"$work/points.toml" <<'EOF2'
format = 1
[[point]]
kind = "start"
name = "inlet"
position_mm = [0.5, 1, 0]
[[point]]
kind = "end"
name = "tube"
position_mm = [0, 29, 0.3]
EOF2
tube="$work/tube.obj" points="$work/points.toml"

"$program" --help >"$log" 2>&1 && grep -q "centreline edit coronaries.obj" "$log" && grep -q "Exit codes" "$log"
result $? "--help shows examples and exit codes"
"$program" fit "$tube" --points "$points" -o "$work/tree.csv" >"$log" 2>&1 && grep -q "^0	tube	-1" "$log" &&
    [ -s "$work/tree.csv" ]
result $? "fit writes a tree and prints its branches"
"$program" auto "$tube" -o "$work/auto.vtp" --points "$work/found.toml" --inlet 0 0 0 >"$log" 2>&1 &&
    grep -q 'kind = "start"' "$work/found.toml"
result $? "auto writes a tree and the points that it found"
"$program" convert "$work/tree.csv" -o "$work/a.vtp" >"$log" 2>&1 &&
    "$program" convert "$work/a.vtp" -o "$work/b.obj" >>"$log" 2>&1 &&
    "$program" convert "$work/b.obj" -o "$work/c.mrk.json" >>"$log" 2>&1 &&
    "$program" convert "$work/c.mrk.json" -o "$work/d.csv" >>"$log" 2>&1 &&
    diff <(cut -d, -f6-9 "$work/tree.csv" | tail -n +3) <(cut -d, -f6-9 "$work/d.csv" | tail -n +3) >>"$log"
result $? "convert by way of every format keeps every sphere"
"$program" convert "$work/tree.csv" --radii-times 1.5 --axes +y,-x,+z -o "$work/wide.csv" >"$log" 2>&1 &&
    paste -d, <(tail -n +3 "$work/tree.csv") <(tail -n +3 "$work/wide.csv") |
    awk -F, '{r = $20 - 1.5 * $9; x = $17 - $7; y = $18 + $6; if (r * r + x * x + y * y > 1e-8) bad = 1} END {exit bad}'
result $? "convert widens and turns as it is told"
refuse_axes() { "$program" convert "$work/tree.csv" --axes "$1" -o "$work/no.csv" >"$log" 2>&1; [ $? = 2 ] &&
    [ ! -e "$work/no.csv" ]; }
refuse_axes +x,+y && refuse_axes +x,+x,+z && refuse_axes -x,+y,+z && refuse_axes +x,+y,+w
result $? "axes that are too few, twice the same, mirrored or unknown are wrong usage"
grep -v radius_mm "$work/b.obj" >"$work/bare.obj"
"$program" convert "$work/bare.obj" --radii-from "$tube" -o "$work/measured.csv" >"$log" 2>&1 &&
    awk -F, 'NR > 2 && ($9 < 1.9 || $9 > 2.01) {bad = 1} END {exit bad}' "$work/measured.csv"
result $? "convert measures radii in a mesh"
"$program" show "$work/tree.csv" --mesh "$tube" -o "$work/show.png" --size 300 >"$log" 2>&1 &&
    [ "$(head -c 4 "$work/show.png" | tail -c 3)" = PNG ]
result $? "show writes a picture"
"$program" show --wireframe --mesh "$tube" -o "$work/wires.png" --size 300 >"$log" 2>&1 && [ -s "$work/wires.png" ]
result $? "show draws a mesh as wires without a tree"
"$program" show --mesh "$tube" -o "$work/none.png" >"$log" 2>&1; [ $? = 2 ] && grep -q "name a TREE" "$log"
result $? "without both it says what is missing"
mkdir "$work/frames"
for i in 0 1 2; do awk -v up="$i" '/^v/ {$4 += up} {print}' "$tube" >"$work/frames/f$i.obj"; done
"$program" carry "$work/tree.csv" "$work/frames" -o "$work/beat" >"$log" 2>&1 &&
    [ "$(ls "$work/beat")" = "$(printf 'tree_0.csv\ntree_1.csv\ntree_2.csv')" ] &&
    paste -d, <(tail -n +3 "$work/beat/tree_0.csv") <(tail -n +3 "$work/beat/tree_2.csv") |
        awk -F, '{off = $19 - $8 - 2; if (off < 0) off = -off; if (off > 0.1) bad = 1} END {exit bad}'
result $? "carry takes the spheres along, frame by frame"

printf '%s\n' '[scene]' 'name = "t"' '[lumen]' 'centrelines = ["tree.csv"]' '[entry]' 'position_mm = [0, 9, 0]' \
    'direction = [0, 1, 0]' >"$work/scene.toml"
"$build/bin/bake" "$work/scene.toml" -o "$work/t.scene" --poses 0 --points 100 >"$log" 2>&1 &&
    grep -q "^vessels *1 branch" "$log"
result $? "bake makes a lumen and its tree of vessels from what was fitted"

refuse() { # name, exit code, pattern, arguments ...
    local name="$1" code="$2" pattern="$3"
    shift 3
    "$program" "$@" >"$log" 2>&1
    [ $? = "$code" ] && grep -Eq -e "$pattern" "$log" && [ ! -e "$work/no.csv" ]
    result $? "$name"
}
refuse "no command is wrong usage" 2 "subcommand"
refuse "an unknown option is wrong usage" 2 "--fast" auto "$tube" -o "$work/no.csv" --fast
refuse "an output onto the mesh is wrong usage" 2 "would overwrite what MESH reads" auto "$tube" -o "$tube"
refuse "an unknown ending is refused" 1 "use .csv, .mrk.json, .vtp or .obj" auto "$tube" -o "$work/no.txt"
refuse "a missing mesh is refused" 1 "gone.obj" auto "$work/gone.obj" -o "$work/no.csv"
refuse "an open mesh is refused where nothing may be capped" 1 "2 openings" auto "$tube" --cap none -o "$work/no.csv"
echo 'format = 1
[[point]]
kind = "begin"
position_mm = [0, 0, 0]' >"$work/bad.toml"
refuse "a point of unknown kind is refused with its line" 1 "bad.toml:3:8: point 1: 'kind' is 'begin'" fit "$tube" \
    --points "$work/bad.toml" -o "$work/no.csv"
sed 's/\[0, 29, 0.3\]/[0, 29]/' "$points" >"$work/bad.toml"
refuse "a position of two numbers is refused with its line" 1 "bad.toml:9:15: point 2: 'position_mm'" fit "$tube" \
    --points "$work/bad.toml" -o "$work/no.csv"
sed 's/29, 0.3/290, 0.3/' "$points" >"$work/bad.toml"
refuse "a point outside the vessel is refused by name" 1 "end point 'tube' at \(0.0, 290.0, 0.3\) mm" fit "$tube" \
    --points "$work/bad.toml" -o "$work/no.csv"
env -u DISPLAY -u WAYLAND_DISPLAY "$program" edit "$tube" --project "$work/none.toml" >"$log" 2>&1
[ $? = 1 ] && grep -q "no display" "$log"
result $? "without a display the editor says so"

# A person: start below, end above, a third point taken back, fit, save.
cat >"$work/person.sh" <<'EOF2'
"$program" edit "$tube" --project "$work/p.toml" -o "$work/edited.csv" --screenshot "$work/edit.png" >"$work/log" 2>&1 &
editor=$!
for _ in $(seq 600); do window=$(xdotool search --name "Cournand centreline" 2>/dev/null) && break; sleep 0.05; done
xdotool windowfocus "$window"
# Saves until the project has so many points: the editor has heard everything before, on a machine of any speed.
saved() {
    for _ in $(seq 200); do
        xdotool key ctrl+s
        sleep 0.1
        [ "$(grep -c kind "$work/p.toml" 2>/dev/null)" = "$1" ] && return
    done
}
at() { xdotool mousemove --window "$window" "$1" "$2"; sleep 0.1; xdotool click 1; saved "$3"; }
saved 0; at 384 700 1; at 384 80 2; at 384 400 3
xdotool key ctrl+z; saved 2
xdotool key ctrl+z; saved 1
xdotool key ctrl+y; saved 2
xdotool key f
xdotool key Escape
wait "$editor"
EOF2
export program tube work
timeout 60 bash "$work/person.sh"
[ $? = 0 ] && [ "$(grep -c kind "$work/p.toml")" = 2 ] && grep -q 'kind = "start"' "$work/p.toml" &&
    grep -q 'kind = "end"' "$work/p.toml"
result $? "clicks set points, undo and redo, and the project is saved at the end"
[ -s "$work/edited.csv" ] && awk -F, 'NR > 3 && ($6 * $6 + $8 * $8 > 0.04) {bad = 1} END {exit bad}' "$work/edited.csv"
result $? "F fits a tree in the middle of the vessel, and it is written"
"$program" edit "$tube" --project "$work/p.toml" --frames 3 >"$log" 2>&1 && [ "$(grep -c kind "$work/p.toml")" = 2 ]
result $? "the project is resumed"
cp "$work/p.toml" "$work/kept.toml"
cat >"$work/stop.sh" <<'EOF2'
env --default-signal=INT "$program" edit "$tube" --project "$work/p.toml" >"$work/log" 2>&1 &
editor=$!
for _ in $(seq 200); do xdotool search --name "Cournand centreline" >/dev/null 2>&1 && break; sleep 0.05; done
sleep 0.3
kill -INT "$editor"
wait "$editor"
EOF2
timeout 60 bash "$work/stop.sh"
code=$?
echo "exit code $code" >>"$log"
[ $code = 1 ] && grep -q "points are saved" "$log" && cmp -s "$work/p.toml" "$work/kept.toml"
result $? "Ctrl-C saves the points and ends with 1"
"$program" edit "$work/frames/f1.obj" --project "$work/p.toml" >"$log" 2>&1
[ $? = 1 ] && grep -q "belongs to the mesh" "$log"
result $? "a project of another mesh is refused"
echo "1..$number"
exit $failed
