#!/usr/bin/env bash
# Tests `cournand` without any other word: without a display it prints commands, every one of which works as it is
# printed; with a display it opens the window on the scene that comes with the program.
set -u
. "$(dirname "$0")/program.sh"
. "$(dirname "$0")/display.sh"
headless=$build/test/cournand_headless
export XDG_STATE_HOME="$work/state" XDG_CACHE_HOME="$work/cache" XDG_DATA_HOME="$work/data"
mkdir "$work/here" && cd "$work/here" || exit 1

env -u DISPLAY -u WAYLAND_DISPLAY "$program" >"$work/said" 2>"$log" && [ ! -s "$log" ] &&
    [ "$(wc -l <"$work/said")" -le 23 ]
result $? "without a display it prints one screenful and ends with 0"
"$headless" >"$work/headless" 2>&1 && sed "s#$headless#$program#" "$work/headless" | cmp -s - "$work/said"
result $? "a program that was built without its window prints the same, even where there is a display"

sed -n 's/^    //p' "$work/said" >"$work/commands"
[ "$(wc -l <"$work/commands")" -ge 8 ]
result $? "it prints commands"
while read -r command; do
    env -u DISPLAY bash -c "$command" >"$log" 2>&1 </dev/null
    result $? "the printed command works: ${command#"$program" }"
done <"$work/commands"
[ -s demo.mp4 ] && [ -s two.png ] && [ -s demo.rec ]
result $? "their files are in the current folder"

"$program" replay last >"$log" 2>&1
[ $? = 2 ] && grep -q "no recording is kept" "$log"
result $? "without a kept recording, 'last' is refused"
"$program" >"$log" 2>&1 &
window=$!
focus && keys key a # free practice in the aorta
until kept=$(ls "$work"/state/cournand/*.rec.part* 2>>"$log") || ! kill -0 $window 2>>"$log"; do sleep 0.05; done
ticks_pass "${kept%.part*}" 2
while kill -0 $window 2>>"$log"; do keys key Escape; sleep 0.2; done # back through the debrief and the start screen
wait $window
result $? "with a display it opens the start screen, whose free practice begins with a key; Esc leads back and ends it"
"$program" replay last --verify >"$log" 2>&1 && grep -q "^verified" "$log" &&
    "$program" info last >"$log" 2>&1 && grep -q "^scene .*aorta.scene" "$log" && grep -q "^tool 1 .*Cook J" "$log"
result $? "the window had the aorta and a J wire, and its recording is the last one"
"$program" view --no-record --frames 2 --size 64 >"$log" 2>&1
result $? "view needs no options either"
echo "1..$number"
exit $failed
