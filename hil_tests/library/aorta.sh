#!/bin/sh
# The aorta session of `make run` by the program cournand, unmodified, on the rig that it finds on USB. Runs on a mocked bus (L2), in
# the guest (L3), or on a desk. Prints TAP. $AORTA_HASH: the final hash that it has to have; without, the host alone tells.
build="${BUILD:-build}"
session="--scene ${AORTA_SCENE:-out/aorta.scene} --tool shared/examples/instruments/j_wire.toml --session shared/examples/sessions/demo.session"
final='s/^final hash *//p'

hash="${AORTA_HASH:-$("$build/bin/cournand" run --quiet $session | sed -n "$final")}"
# shellcheck disable=SC2086 # words on purpose
output=$("$build/bin/cournand" run --quiet --device "usb${RIG_SERIAL:+:$RIG_SERIAL}" $session "$@" 2>&1)
status=$?
got=$(echo "$output" | sed -n "$final")
echo "$output" | sed -n 's/^wall clock */#- /p; s/^device  */#- /p'
echo "$output" | grep -e '^ticks' -e '^final' -e '^wall' -e '^device' | sed 's/^/# /'
if [ $status = 0 ] && [ -n "$hash" ] && [ "$hash" = "$got" ]; then
    echo "ok 1 - the_aorta_session_on_usb_has_the_hash_of_the_host_alone"
    status=0
else
    echo "$output" | sed 's/^/# /'
    echo "# expected hash ${hash:-none}, exit code $status"
    echo "not ok 1 - the_aorta_session_on_usb_has_the_hash_of_the_host_alone"
    status=1
fi
echo "1..1"
exit $status
