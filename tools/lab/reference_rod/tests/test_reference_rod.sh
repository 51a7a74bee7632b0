#!/bin/sh
# Tests the program `reference_rod`: a case in a bent tube baked for it, the same bytes from the same command, the truth
# kept apart from the files that calibrate may read, and messages for bad command lines. It takes 4 s of processor time:
# a lumen to bake and four insertions. Prints TAP.
programs="reference_rod bake"
. "$(dirname "$0")/../../../check/tool.sh"

awk 'BEGIN { print "branch,x_mm,y_mm,z_mm,radius_mm"
             for (i = 0; i <= 40; i++) printf "0,0,%g,0,5\n", i
             for (i = 1; i <= 60; i++) printf "0,%g,%g,0,5\n", 40 * (1 - cos(i / 40)), 40 + 40 * sin(i / 40) }' \
    >"$work/tube.csv"
cat >"$work/scene.toml" <<'END'
[scene]
name = "bent tube"
[lumen]
centrelines = ["tube.csv"]
[entry]
position_mm = [0, 8, 0]
direction = [0, 1, 0]
END
"$BUILD/bin/bake" "$work/scene.toml" -o "$work/tube.scene" --points 1000 --poses 0 >"$work/bake.said" 2>&1
result=$?
report "a bent tube is baked" $result
[ $result = 0 ] || sed 's/^/# /' "$work/bake.said"

wire=shared/examples/instruments/bentson.toml
make_case() { # make_case FOLDER ARGUMENTS...
    folder=$1
    shift
    "$tool" --instrument "$wire" --scene "$work/tube.scene" --depth near:25:0 --depth far:55:30 --shaft-factor 1.5 \
        --tip-factor 0.5 \
        "$@" -o "$work/$folder" >"$work/$folder.said" 2>&1
}
make_case one --shape-noise-mm 0.1
result=$?
report "a case is made" $result
[ $result = 0 ] || sed 's/^/# /' "$work/one.said"

make_case two --shape-noise-mm 0.1 && diff -r "$work/one" "$work/two" >"$work/differ"
report "the same command makes the same files" $?
make_case three --shape-noise-mm 0.1 --seed 2 && diff "$work/one/truth/depth_2.csv" "$work/three/truth/depth_2.csv" &&
    ! diff -q "$work/one/depth_2.csv" "$work/three/depth_2.csv" >"$work/differ"
report "another seed makes other noise of the same truth" $?
make_case scan && [ -e "$work/scan/truth/depth_1.csv" ] && [ ! -e "$work/scan/depth_1.csv" ]
report "without noise the depths are left to a scan" $?

# The file has 3e-4 and 2e-6/3e-4; the truth has 1.5 and 0.5 times that. Every step is at rest.
awk -F' = ' '
    $1 == "shaft_bend_stiffness_N_m2" { shaft = $2 }
    $1 == "tip_over_shaft" { tip = $2 }
    $1 == "steps_not_at_rest" { bad = $2 }
    END { exit !(shaft > 4.4e-4 && shaft < 4.6e-4 && tip > 0.0032 && tip < 0.0035 && bad == 0) }
    ' "$work/one/truth/parameters.toml"
report "truth/parameters.toml has the stiffness that was asked for" $?
grep -q "shaft\|factor" "$work/one/case.toml"
[ $? = 1 ] && cmp -s "$wire" "$work/one/instrument.toml"
report "what calibrate reads does not have it" $?

# The wire's tip lies within the tube, 55 mm along it from the sheath's end, up to the 3 mm by which it may cut the
# corner.
awk -F, 'NR > 2 { length_mm += sqrt(($1 - x) ^ 2 + ($2 - y) ^ 2 + ($3 - z) ^ 2) } NR > 1 { x = $1; y = $2; z = $3 }
    END { rho = sqrt((x - 40) ^ 2 + (y - 40) ^ 2)
          exit !(length_mm > 54.9 && length_mm < 55.1 && rho > 35 && rho < 45) }' \
    "$work/one/truth/depth_2.csv"
report "the wire is as long as what was inserted, and in the tube" $?

refuses "a depth without a turn is refused" 2 "NAME:INSERTED_MM:TURN_DEG" \
    --instrument "$wire" --scene "$work/tube.scene" --depth near:25 -o "$work/bad"
refuses "a missing scene is named" 1 "nowhere.scene" --instrument "$wire" --scene "$work/nowhere.scene" \
    --depth near:25:0 -o "$work/bad"
refuses "an instrument that is too short is told" 1 "too short to insert" \
    --instrument "$wire" --scene "$work/tube.scene" --depth far:1449:0 -o "$work/bad"
refuses "help shows an example" 0 "shaft-factor 1.3" --help

echo "1..$number"
exit $failed
