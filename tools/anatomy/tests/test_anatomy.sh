#!/bin/sh
# Tests the anatomies that ship: their meshes, the nesting of their bodies, the stated dimensions, that two runs give
# the same bytes, and messages about wrong command lines. Bodies are coarser than usual (--body-scale 2) to save time.
programs=anatomy
. "$(dirname "$0")/../../check/tool.sh"

check() { # check NAME runs the independent checks of one folder; five TAP lines
    python3 "$here/check_meshes.py" "$work/$1" "$work/$1.tsv" $((number + 1)) || failed=1
    number=$((number + 5))
}

for name in aorta phantom; do
    "$tool" "$name" -o "$work/$name" --body-scale 2 --quiet >/dev/null && "$tool" list "$name" >"$work/$name.tsv"
    report "$name is made" $?
    check "$name"
done

"$tool" phantom -o "$work/again" --body-scale 2 --quiet >/dev/null && diff -r "$work/phantom" "$work/again" >/dev/null
report "the same command writes the same bytes" $?

lumen=$(sed -n 's/^element face //p' "$work/aorta/lumen.ply" | head -1 | tr -d '\r')
[ "${lumen:-999999}" -le 80000 ]
report "the aorta's lumen has at most 80,000 triangles" $?

awk -F'\t' 'NR > 1 && $2 != "length" && $NF == "" { bad = 1 } END { exit bad }' "$work/aorta.tsv"
report "every stated diameter has a source or is called assumed" $?

refuses "a missing subcommand is a usage error" 2 "subcommand is required"
refuses "a missing folder is a usage error" 2 "output" aorta
refuses "an unknown anatomy is a usage error" 2 "liver" list liver
refuses "a grid spacing out of range is a usage error" 2 "lumen-mm" phantom -o "$work/x" --lumen-mm 9
refuses "a number that is none is a usage error" 2 "body-scale" phantom -o "$work/x" --body-scale fine
: >"$work/file"
refuses "a folder that cannot be made fails and names it" 1 "$work/file/in" phantom -o "$work/file/in"
refuses "help shows examples" 0 "Examples" --help

echo "1..$number"
exit $failed
