#!/bin/sh
# The validation suite in its quick form: every case's figures within their tolerances. Then the table that docs/validation.md
# holds: one line per case, all passed. And the command line refuses what it cannot do.
BUILD=${BUILD:-build}
tool=$BUILD/bin/validate
make -s PACKAGES=skip BUILD="$BUILD" "$tool" >/dev/null || { echo "1..1"; echo "not ok 1 - validate builds"; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
number=0

report() { # report NAME STATUS
    number=$((number + 1))
    if [ "$2" = 0 ]; then echo "ok $number - $1"; else echo "not ok $number - $1"; failed=1; fi
}

# The quick suite prints TAP itself: its plan is left out and its lines keep their numbers.
"$tool" --quick --tap >"$work/tap" || failed=1
sed '/^1\.\./d' "$work/tap"
number=$(grep -cE '^(not )?ok ' "$work/tap")
[ "$number" -gt 0 ] || report "the quick suite ran" 1

"$tool" --list >"$work/names"
while read -r name; do grep -q "(\`$name\`)" docs/validation.md || echo "# $name"; done <"$work/names" >"$work/missing"
cat "$work/missing"
[ ! -s "$work/missing" ]
report "docs/validation.md has a line for every case (make validate renews it)" $?

rows=$(sed -n '/begin: written by/,/<!-- end/p' docs/validation.md | grep -c '^| [^c-]')
[ "$rows" = "$(wc -l <"$work/names")" ]
report "docs/validation.md has no line for a case that is gone" $?

"$tool" --only three_point --quick -o "$work/out" >"$work/said" 2>&1
head -1 "$work/out/validation.tsv" | grep -qx "$(printf 'name\tformula\tsource\tunit\treference\tvalue\terror\ttolerance\terror_unit\tverdict')" &&
    awk -F'\t' 'NF != 10 || $1 !~ /^three_point\./ && NR > 1 {exit 1}' "$work/out/validation.tsv" &&
    grep -q '<svg' "$work/out/validation.html"
report "one case alone writes its table and its page" $?

"$tool" --only no_such_case >"$work/said" 2>&1
[ $? = 2 ] && grep -q "no case has 'no_such_case'" "$work/said"
report "a name that no case has is refused" $?

"$tool" --jobs 0 >"$work/said" 2>&1
[ $? = 2 ]
report "a bad option is refused" $?

"$tool" --only three_point --quick -o "$work/out" --docs "$work/said" >"$work/complaint" 2>&1
[ $? = 1 ] && grep -q "to write between" "$work/complaint"
report "a page without marks is left alone" $?

echo "1..$number"
exit $failed
