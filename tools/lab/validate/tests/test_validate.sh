#!/bin/sh
# Tests the validation suite in its quick form: every case's figures are within their tolerances. The table in
# docs/validation.md has one line per case, and all have passed. The command line refuses what it cannot do.
programs=validate
. "$(dirname "$0")/../../../check/tool.sh"

# The quick suite prints TAP itself: we drop its plan, and its lines keep their numbers.
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
head -1 "$work/out/validation.tsv" | grep \
    -qx "$(printf 'name\tformula\tsource\tunit\treference\tvalue\terror\ttolerance\terror_unit\tverdict')" &&
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
