#!/bin/sh
# Tests a lesion from the command line of `anatomy`, through `bake`, to the report of a session of `cournand`.
programs="anatomy bake cournand"
. "$(dirname "$0")/../../check/tool.sh"
wire=shared/examples/instruments/bentson.toml

"$tool" phantom -o "$work/p" --no-bodies --quiet --lesion left_renal_artery:75:14:10 \
    --lesion right_renal_artery:40:10:12:1:90 >"$work/said" 2>&1 &&
    [ "$(grep -c '^\[\[lesion\]\]' "$work/p/scene.toml")" = 2 ] && grep -q '^eccentricity = 1$' "$work/p/scene.toml"
report "anatomy writes lesions into the scene's text" $?

"$BUILD/bin/bake" "$work/p/scene.toml" -o "$work/p.scene" --points 1000 --poses 0 >"$work/said" 2>&1 &&
    grep -q "^lesion *lesion_1 in left_renal_artery: 1.50 of 6.00 mm diameter left.*75 % by diameter, 94 % by area" \
    "$work/said" &&
    grep -q "^lesion *lesion_2 in right_renal_artery: 3.60 of" "$work/said"
report "bake makes them and says how narrow they are" $?

printf 'wait 0.1 s\n' >"$work/short.session"
"$BUILD/bin/cournand" run --scene "$work/p.scene" --tool $wire --session "$work/short.session" \
    --json "$work/s.json" --png "$work/s.png" --size 64 >"$work/said" 2>&1 &&
    python3 - "$work/s.json" >>"$work/said" 2>&1 <<'PY'
import json, sys
one, two = json.load(open(sys.argv[1]))["lesions"]
print(one, two)
assert one["branch"] == "left_renal_artery" and two["branch"] == "right_renal_artery"
assert abs(one["stenosis_diameter_pct"] - 75) < 0.1 and abs(one["stenosis_area_pct"] - 93.75) < 0.1
assert abs(two["stenosis_diameter_pct"] - 40) < 0.1
assert one["rest_drop_mmHg"] > 10 * two["rest_drop_mmHg"] > 0  # a wider minimal lumen costs far less pressure
assert 0 < one["ffr"] < two["ffr"] < 1
PY
report "a session's report has their diameters, drops and flow reserves" $?

sed 's/^branch = "left_renal_artery"/branch = "splenic"/' "$work/p/scene.toml" >"$work/p/bad.toml"
"$BUILD/bin/bake" "$work/p/bad.toml" -o "$work/bad.scene" >"$work/said" 2>&1
[ $? = 1 ] && grep -q "'lesion_1' lies on 'splenic', which is no branch: there are aorta" "$work/said" &&
    [ ! -e "$work/bad.scene" ]
report "bake refuses one on a branch that is not there, and writes nothing" $?

refuses "a lesion with too few numbers is a usage error" 2 "like LAD:75:14:22" phantom -o "$work/x" --lesion aorta:75
refuses "a lesion's number that is none is a usage error" 2 "'wide' is no number" phantom -o "$work/x" \
    --lesion aorta:wide:14:22
refuses "a lesion that bake would refuse is a usage error" 2 "PERCENT must be 1 to 95" phantom -o "$work/x" \
    --lesion aorta:100:14:22
refuses "a number that is none, in words, too" 2 "LENGTH_MM must be 2 to 100" phantom -o "$work/x" \
    --lesion aorta:75:nan:22
refuses "a lesion on a vessel that is not there is a usage error" 2 "there are aorta, right_iliac_artery" phantom \
    -o "$work/x" --lesion LAD:75:14:22
[ ! -e "$work/x" ]
report "what is refused has written nothing" $?
echo "1..$number"
exit $failed
