#!/bin/sh
# Two rigs at once, distinguished by serial number, with a session on each at the same time and the hash of the sim.
# Prints TAP.
#   two_rigs.sh SERIAL SERIAL
build="${BUILD:-build}"
count=0
status=0

verdict() {
    count=$((count + 1))
    [ "$1" = 0 ] && echo "ok $count - $2" && return
    status=1
    echo "not ok $count - $2"
}

list=$("$build/bin/cournand" rig list)
echo "$list" | grep -q "^$1 " && echo "$list" | grep -q "^$2 "
verdict $? both_rigs_are_listed_by_their_serial_numbers
"$build/bin/cournand" rig info --device usb 2>&1 | grep -q 'several rigs are there'
verdict $? a_rig_without_a_name_is_refused_when_there_are_two
one() { "$build/bin/cournand" run --quiet --device "$1" --tool shared/examples/instruments/j_wire.toml \
    --session hil_tests/library/short.session 2>&1; }
wanted=$(one sim | sed -n 's/^final hash *//p')
first=$(one "usb:$1" & one "usb:$2" >&2; wait) 2>/dev/null
[ -n "$wanted" ] && [ "$(echo "$first" | sed -n 's/^final hash *//p')" = "$wanted" ]
verdict $? a_session_on_the_first_while_the_second_has_one
second=$(one "usb:$2" & one "usb:$1" >&2; wait) 2>/dev/null
[ -n "$wanted" ] && [ "$(echo "$second" | sed -n 's/^final hash *//p')" = "$wanted" ]
verdict $? and_the_other_way_round
[ $status = 0 ] || { echo "$list"; echo "$first"; echo "$second"; } | sed 's/^/# /'
echo "1..$count"
exit $status
