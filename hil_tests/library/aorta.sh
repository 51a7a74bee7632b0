#!/bin/sh
# Runs the aorta session of `make run` with the unmodified program cournand on the rig that it finds on USB. The bus is
# a mocked one (L2), one in the guest (L3), or a real one. Prints TAP. $AORTA_HASH is the required final hash; without
# it, the host alone computes it.
build="${BUILD:-build}"
session="--scene ${AORTA_SCENE:-out/aorta.scene} --tool shared/examples/instruments/j_wire.toml
    --session shared/examples/sessions/demo.session"
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
