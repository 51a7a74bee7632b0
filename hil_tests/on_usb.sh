#!/bin/sh
# Levels L2 and L3: what runs there, each selected by one word. libusb and hidapi, as shipped, access the device on a
# mocked bus (L2) or in a guest with Debian's kernel (L3). Prints TAP, or the table of the program hil.
#
#   on_usb.sh L2|L3 cases        the cases of the program hil on the image, with the plant
#   on_usb.sh L2|L3 aorta        the aorta session by cournand on the image: $AORTA_HASH, or the host alone
#   on_usb.sh L2|L3 free_run     the rig leads for $SECONDS s, with power; the host replays the recording bit for bit
#   on_usb.sh L2|L3 checks       libusb and both back ends of hidapi against a rig that sends everything back
#   on_usb.sh L2|L3 app          a session with the whole app, in a process and on the image
#   on_usb.sh L2|L3 board        the same with the board's own image on its emulated chip (docs/rt1062.md)
#   on_usb.sh L2|L3 two          two rigs at once, distinguished by their serial numbers
#   on_usb.sh L2|L3 unplug       the cable is pulled in a session, which continues to the same hash
#   on_usb.sh L2|L3 rig          make hil-rig, with the emulated rig in the place of a real one
# Run it from the root of the tree. $URGENT is put before everything that is measured.
level="$1"
what="$2"
build="${BUILD:-build}"
hil="${HIL:-$build/hil}"
[ -n "$URGENT" ] || [ "$(id -u)" != 0 ] || URGENT="nice -n -10"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
case "$level" in
L2) place="$folder" ;;
L3) place=/mnt ;;
*) echo "usage: on_usb.sh L2|L3 cases|aorta|free_run|checks|app|board|two|unplug|rig" >&2 && exit 2 ;;
esac

# bus DEVICES... -- COMMAND: runs the command with access to the devices
bus() {
    if [ "$level" = L2 ]; then
        # shellcheck disable=SC2086
        ASAN_OPTIONS=detect_leaks=0 $before env LD_PRELOAD=libumockdev-preload.so.0 "$hil/mock_bus" "$@"
    else
        # shellcheck disable=SC2086
        $before hil_tests/l3/run_guest.py --bridge "$hil/bridge" --kernel "$hil/kernel" --seconds "${LIMIT:-180}" \
            --out "$folder" $channel "$@"
    fi
}
in_rig() { before="$URGENT $build/bin/hil_rig $1 --"; }
before="$URGENT"
channel=""

case "$what" in
cases)
    in_rig ""
    if [ "$level" = L2 ]; then bench="{bench}"; else bench=/dev/vport2p1 && channel="--channel {bench}"; fi
    # shellcheck disable=SC2086
    bus --mailbox '{mailbox}' -- "$build/bin/hil" --level "$level" --bench "$bench" --no-aorta \
        ${SHORT:---pause 0.2 --ticks 400 --free-run 600 --spread 6}
    ;;
aorta)
    in_rig --live
    bus --mailbox '{mailbox}' -- env BUILD="$build" AORTA_HASH="$AORTA_HASH" hil_tests/library/aorta.sh
    ;;
free_run)
    in_rig --live
    bus --mailbox '{mailbox}' -- env BUILD="$build" hil_tests/library/free_run.sh "${SECONDS_LED:-60}" "$place" ||
        exit 1
    if "$build/bin/cournand" replay "$folder/free_run.rec" --verify >"$folder/replay.log"; then
        echo "ok 5 - the_recording_replays_bit_for_bit"
        sed -n 's/^verified: /#- replayed: /p' "$folder/replay.log"
    else
        echo "not ok 5 - the_recording_replays_bit_for_bit"
        exit 1
    fi
    ;;
checks)
    bus --here -- env HIL="$hil" hil_tests/l3/checks.sh
    ;;
app)
    bus --app -- "$hil/app_check" || exit 1
    in_rig --live
    bus --mailbox '{mailbox}' -- "$hil/app_check"
    ;;
board)
    before="$URGENT $hil/hil_rt1062 --image $build/firmware/cournand-imxrt1062.elf --"
    bus --mailbox '{mailbox}' -- "$hil/app_check"
    ;;
two)
    in_rig "--live --serial RIG-B"
    bus --app=RIG-A --mailbox '{mailbox}' -- env BUILD="$build" hil_tests/library/two_rigs.sh RIG-A RIG-B
    ;;
unplug)
    in_rig --live
    bus --mailbox '{mailbox}' -- env BUILD="$build" HIL="$hil" AORTA_HASH="$AORTA_HASH" hil_tests/library/unplug.sh \
        "$place"
    ;;
rig)
    in_rig "--live --serial RIG-0001"
    bus --mailbox '{mailbox}' -- "$build/bin/hil" --level rig --serial RIG-0001
    ;;
*) echo "on_usb.sh: '$what' is none of its words" >&2 && exit 2 ;;
esac
