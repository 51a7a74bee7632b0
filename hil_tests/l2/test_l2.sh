#!/bin/sh
# Level L2: libusb and hidapi, unmodified, see the loop-back rig, the whole app and the image on a machine without USB.
# Prints TAP. The programs come from $HIL, by default the sanitized ones: all their calls and the whole stack run under
# the address and undefined-behaviour sanitizers. (umockdev itself has leaks until it ends, so leaks are not checked.)
folder="${HIL:-${BUILD:-build}/san/hil}"
# In `make test` (which sets no folder) no verdict depends on the machine's pace, such as whether a reader keeps up
# with 1,000 reports a second.
[ -n "$HIL" ] || export UNPACED=1
# gcc's address sanitizer is a library that must be loaded first; clang's is in the program.
preload="$(ldd "$folder/mock_bus" | awk '/libasan/ { print $3 }') libumockdev-preload.so.0"
count=0
status=0

# run_on_bus COMMAND...: puts its output into $output and returns its status. umockdev before its pull request 254
# (Debian 12 has it so) ends itself when a listener disappears while umockdev reports a device to it. That is no
# verdict on the tested program, so the run is repeated, twice at most.
run_on_bus() {
    for try in 1 2 3; do
        output=$("$@" 2>&1)
        state=$?
        case "$output" in
        *"uevent_sender sendmsg_one: sendmsg failed: Connection refused"*) echo "# umockdev ended itself in try $try" ;;
        *) break ;;
        esac
    done
    return $state
}

# one DEVICE NAME PROGRAM ARGUMENT...: prints the program's own verdict, with its figures as notes
one() {
    device="$1"
    name="$2"
    program="$3"
    shift 3
    count=$((count + 1))
    if run_on_bus env ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD="$preload" timeout 60 "$folder/mock_bus" "$device" \
        -- "$program" "$@"; then
        echo "ok $count - ${name}_on_a_mocked_bus"
        echo "$output" | grep '^# link'
    else
        status=1
        echo "not ok $count - ${name}_on_a_mocked_bus"
        echo "$output" | sed 's/^/# /'
    fi
}

# The programs run one after the other on one bus: none may leave anything behind for the next.
one --here libusb_and_both_hidapis_pass env HIL="$folder" "$(dirname "$0")/../l3/checks.sh"
one --app the_whole_app_passes "$folder/app_check"

# The image on the emulated Cortex-M7.
count=$((count + 1))
image="${BUILD:-build}/firmware/cournand-mps2_an500.elf"
here="$(dirname "$0")"
if run_on_bus "$here/../usb/with_image.py" "$image" env ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD="$preload" timeout 60 \
    "$folder/mock_bus" --mailbox '{mailbox}' -- "$folder/app_check"; then
    echo "ok $count - the_image_passes_on_a_mocked_bus"
    echo "$output" | grep '^# link'
else
    status=1
    echo "not ok $count - the_image_passes_on_a_mocked_bus"
    echo "$output" | sed 's/^/# /'
fi
echo "1..$count"
exit $status
