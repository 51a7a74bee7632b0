#!/usr/bin/env bash
# The soak on vessels: a few dozen short sessions of a fixed seed in the phantom, run twice: once without a break, and
# once interrupted and continued. `cournand run` accepts a printed session and gives the same hash. A bar that is
# deliberately too low is found, and shrinks to a short script that shows it. A changed recording is reported.
set -u
. "$(dirname "$0")/../../host/app/tests/program.sh"
soak="$build/bin/soak"
[ -x "$soak" ]
result $? "the soak is built"

"$build/bin/anatomy" phantom --no-bodies --quiet -o "$work/phantom" >"$log" 2>&1 &&
    "$build/bin/bake" "$work/phantom/scene.toml" --points 1000 --poses 0 -o "$work/phantom.scene" >>"$log" 2>&1
result $? "a phantom is baked"
scene=(--scene "$work/phantom.scene")
short=(--seed 3 --seconds-min 1 --seconds-max 3 --session-ticks 6000 --ticks 0 --jobs 2)
rows() { grep -v '^#' "$1" | sort; }

# The long soak tests what the present core breaks: here the bars are out of reach, so that only the program itself is
# tested.
free=(--penetration-mm 1e9 --length-pct 1e9 --force-N 1e9 --shrink 4)
"$soak" "${scene[@]}" "${short[@]}" "${free[@]}" --sessions 24 --folder "$work/whole" >"$log" 2>&1
whole=$?
[ "$(grep -c "phantom.scene" "$work/whole/seed_3.tsv")" = 25 ] # 24 rows and the key
result $? "two dozen sessions have a row each"

! grep -qP "\t(replay|error|iodine|crash|time)\t" "$work/whole/seed_3.tsv"
result $? "none is refused, none differs in its replay, none loses iodine"

grep -qP "^soak.sessions\t24\t" "$work/whole/soak.tsv" && grep -qP "^soak.ticks\t\d+\t" "$work/whole/soak.tsv" &&
    broken=$(awk '$1 == "soak.broken" {print $2}' "$work/whole/soak.tsv") && [ "$whole" = $((broken > 0)) ]
result $? "the summary counts them, and the exit code says whether a bar broke"

"$soak" "${scene[@]}" "${short[@]}" "${free[@]}" --sessions 24 --folder "$work/parts" >"$log" 2>&1 &
pid=$!
for _ in $(seq 200); do
    [ "$(rows "$work/parts/seed_3.tsv" 2>/dev/null | wc -l)" -ge 4 ] && break
    sleep 0.1
done
kill -INT $pid 2>/dev/null
wait $pid
first=$(rows "$work/parts/seed_3.tsv" | wc -l)
[ -s "$work/parts/soak.tsv" ] && [ "$first" -ge 4 ]
result $? "Ctrl-C ends it with a summary of what was done"
"$soak" "${scene[@]}" "${short[@]}" "${free[@]}" --sessions 24 --folder "$work/parts" >>"$log" 2>&1
diff <(rows "$work/whole/seed_3.tsv" | sed "s#$work/whole#F#") <(rows "$work/parts/seed_3.tsv" |
    sed "s#$work/parts#F#") >>"$log"
result $? "and the same command goes on to the same rows (after $first)"

# A complete session, run by the program itself.
one=$(awk -F'\t' '$5 == "-" && $6 < 6000 {print $1; exit}' "$work/whole/seed_3.tsv")
"$soak" "${scene[@]}" "${short[@]}" --print "$one" >"$work/one.session" 2>"$log"
sed -n 's/^# build.bin.cournand run //p' "$work/one.session" >"$work/command"
# shellcheck disable=SC2046
"$program" run $(sed "s#FILE#$work/one.session#" "$work/command") >"$work/run" 2>&1
hash=$(awk '/^final hash/ {print $3}' "$work/run")
cp "$work/run" "$log"
[ -n "$hash" ] && [ "$hash" = "$(awk -F'\t' -v one="$one" '$1 == one {print $13}' "$work/whole/seed_3.tsv")" ]
result $? "a printed session is run by cournand to the hash of its row"

# A hand that may feel no more than a millinewton breaks its bar with the first push.
"$soak" "${scene[@]}" "${short[@]}" --force-N 0.001 --folder "$work/planted" --only 1 >"$log" 2>&1
[ $? = 1 ] && grep -q "broken at tick .* force of" "$log" && script="$work/planted/3_1.session" && [ -s "$script" ]
result $? "a planted bar is found, with its tick"
lines=$(grep -vc '^#' "$script") && [ "$lines" -le 3 ] && [ "$lines" -lt "$(grep -vc '^#' "$work/one.session")" ]
result $? "and shrinks to a script of at most three statements ($lines)"
sed -n 's/^# build.bin.cournand run //p' "$script" >"$work/command"
# shellcheck disable=SC2046
"$program" run $(cat "$work/command") >"$work/run" 2>&1
grep -q "largest hand force" "$work/run"
result $? "which the command in it runs"

"$soak" "${scene[@]}" "${short[@]}" "${free[@]}" --disturb-replay 200 --folder "$work/disturbed" --only 1 >"$log" 2>&1
[ $? = 1 ] && grep -q "broken at tick 201: replay: hash lanes are" "$log"
result $? "a recording that was changed is told at its tick"

"$soak" --scene "$work/none.scene" >"$log" 2>&1
[ $? = 2 ] && grep -q "make soak" "$log"
result $? "a scene that is not there is wrong usage, and the message says who makes it"
echo "1..$number"
exit $failed
