#!/bin/sh
# The rig leaves the bus three times in the middle of the aorta session, with transfers under way in both directions.
# The session reaches the hash of an undisturbed one. Prints TAP.
#   unplug.sh FOLDER      the recording is left there
build="${BUILD:-build}"
hil="${HIL:-$build/hil}"
folder="$1"
session="--scene ${AORTA_SCENE:-out/aorta.scene} --tool shared/examples/instruments/j_wire.toml
    --session shared/examples/sessions/demo.session"
hash="${AORTA_HASH:-$("$build/bin/cournand" run --quiet $session | sed -n 's/^final hash *//p')}"
# shellcheck disable=SC2086 # words on purpose
"$build/bin/cournand" run --quiet --device usb --record "$folder/unplug.rec" $session >"$folder/unplug.log" 2>&1 &
program=$!
pulls=0
# The recording begins with the session and grows with it, under another name until it is complete.
has_begun() {
    for file in "$folder"/unplug.rec.part*; do [ -s "$file" ] && return 0; done
    return 1
}
while ! has_begun && kill -0 $program 2>/dev/null; do sleep 0.2; done
sleep 1
while [ $pulls -lt 3 ] && kill -0 $program 2>/dev/null; do
    "$hil/unplug" 300 && pulls=$((pulls + 1))
    sleep 2
done
wait $program
status=$?
grep -e '^final' -e '^device' -e '^cournand' "$folder/unplug.log" | sed 's/^/# /'
sed -n 's/^device  */#- /p' "$folder/unplug.log"
if [ $status = 0 ] && [ -n "$hash" ] && grep -q "^final hash *$hash" "$folder/unplug.log" &&
    grep -q 'came back [1-9]' "$folder/unplug.log"; then
    echo "ok 1 - a_session_goes_on_bit_for_bit_after_the_cable_was_pulled"
else
    sed 's/^/# /' "$folder/unplug.log"
    echo "not ok 1 - a_session_goes_on_bit_for_bit_after_the_cable_was_pulled"
    status=1
fi
echo "1..1"
exit $status
