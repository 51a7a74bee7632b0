#!/bin/bash
# Tests the program that `make run` builds on a machine without a display: it needs no GLFW, and says how to get the
# window.
# shellcheck source=host/app/tests/program.sh
. "$(dirname "$0")/program.sh"
echo 1..4
headless=$build/test/cournand_headless
[ -f out/aorta.scene ] || make -s PACKAGES=skip out/aorta.scene >&2

! ldd "$headless" | grep -qi glfw
result $? "the program without a window needs no GLFW"
"$headless" view --scene out/aorta.scene --instrument shared/examples/instruments/j_wire.toml >"$log" 2>&1
[ $? = 2 ]
result $? "view ends with exit code 2"
grep -q 'built without its window' "$log" && grep -q 'make window' "$log"
result $? "it says why, and which command builds the window"
"$headless" instruments >"$log" 2>&1 && "$program" instruments >"$work/with" 2>&1 && cmp -s "$log" "$work/with"
result $? "other commands print the same with and without a window"
exit $failed
