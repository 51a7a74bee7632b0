#!/bin/sh
# Tests the program `literature`: fast tables give the figures of docs/literature.md, the page has every table, and a
# table that passed before and fails now is an error. The command line refuses what it cannot do.
programs=literature
. "$(dirname "$0")/../../../check/tool.sh"

"$tool" --list >"$work/names"
awk '{print $1}' "$work/names" >"$work/tables"
while read -r name; do grep -q "\`$name\`" docs/literature.md || grep -q "$name.*not reproducible" "$work/names" ||
    echo "# $name"; done <"$work/tables" >"$work/missing"
cat "$work/missing"
[ ! -s "$work/missing" ] && [ "$(grep -c 'not reproducible' "$work/names")" = \
    "$(sed -n '/^## Not reproducible/,/<!-- end/p' docs/literature.md | grep -c '^- \*\*')" ]
report "docs/literature.md has every table (make literature renews it)" $?

# Tables that take seconds, from bending to breathing; each line of the page is what the program says now.
true_pages=0
for name in half_value_layers heart_breath coronary_rest deflection_15_mm fluoroscopy_dose; do
    "$tool" --only "$name" --jobs 1 -o "$work/out" >"$work/said" 2>&1 || true_pages=1
    awk -F'\t' -v table="$name" 'index($1, table ".") == 1 {print $5 "\t" $2}' "$work/out/literature.tsv" \
        >"$work/figures"
    [ -s "$work/figures" ] || true_pages=1
    sed -n "/^\`$name\`/,/^###/p" docs/literature.md >"$work/section"
    while IFS="$(printf '\t')" read -r published ours; do
        grep -qF "| $published | $ours |" "$work/section" || { echo "# $name: $published, ours $ours" && true_pages=1; }
    done <"$work/figures"
done
report "the page has the figures that the program gives" $true_pages

# Where the published figure is the input, the rig must return it.
off=0
for name in flexural_modulus sliding_friction; do
    "$tool" --only "$name" --jobs 1 -o "$work/inputs" >"$work/said" 2>&1 || off=1
    awk -F'\t' 'NR > 1 && ($2 / $5 > 1.01 || $2 / $5 < 0.99) {print "# " $0; bad = 1} END {exit bad || NR < 3}' \
        "$work/inputs/literature.tsv" || off=1
done
report "bending rig and sliding wire return their inputs within a percent" $off

head -1 "$work/out/literature.tsv" | grep \
    -qx "$(printf 'name\tvalue\tunit\tkind\tpublished\tlowest\thighest\tdistance\tverdict')" &&
    ! grep -q "^literature.tables" "$work/out/literature.tsv" &&
    grep -q '<svg' "$work/out/literature/fluoroscopy_dose.svg"
report "one table alone writes its figures and its picture" $?

printf 'half_value_layers\tpass\n' >"$work/expected"
"$tool" --only half_value_layers -o "$work/out" --expected "$work/expected" >"$work/said" 2>&1
[ $? = 1 ] && grep -q "half_value_layers passed before and fails now" "$work/said"
report "a table that passed before and fails now is an error" $?

printf 'heart_breath\tfail\n' >"$work/expected"
"$tool" --only heart_breath -o "$work/out" --expected "$work/expected" >"$work/said" 2>&1 &&
    grep -q "heart_breath passes now: renew" "$work/said"
report "a table that improves asks for a new list" $?

mkdir "$work/tables.d"
sed '/^spread/d' tools/lab/literature/tables/heart_breath.toml >"$work/tables.d/heart_breath.toml"
"$tool" --tables "$work/tables.d" -o "$work/out" >"$work/said" 2>&1
[ $? = 1 ] && grep -q "spread" "$work/said"
report "a table without its spread is refused" $?

rm "$work/tables.d/heart_breath.toml"
cp tools/lab/literature/tables/heart_breath.toml "$work/tables.d/no_experiment.toml"
"$tool" --tables "$work/tables.d" -o "$work/out" >"$work/said" 2>&1
[ $? = 1 ] && grep -q "no experiment has this name" "$work/said"
report "a table without an experiment is refused" $?

"$tool" --only no_such_table >"$work/said" 2>&1
[ $? = 2 ] && grep -q "'no_such_table' in its name" "$work/said"
report "a name that no table has is refused" $?

"$tool" --only heart_breath --expect >"$work/said" 2>&1
[ $? = 2 ] && grep -q "cannot go with --only" "$work/said"
report "a list of some tables is refused" $?

echo "1..$number"
exit $failed
