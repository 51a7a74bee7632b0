#!/bin/sh
# Level L2: the program cournand itself, with libusb and hidapi unmodified, sees the whole app on a machine without USB.
# The programs come from $BUILD; test_l2_rig_sanitized.sh takes the sanitized ones. Prints TAP.
build="${BUILD:-build}"
# gcc's address sanitizer is a library that must be loaded first; clang's is in the program.
preload="$(ldd "$build/hil/mock_bus" | awk '/libasan/ { print $3 }') libumockdev-preload.so.0"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
count=0
status=0

# expect NAME TEXT ARGUMENT...: cournand succeeds and prints TEXT
expect() {
    name="$1"
    text="$2"
    shift 2
    count=$((count + 1))
    if ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD="$preload" timeout 60 "$build/hil/mock_bus" --app \
        -- "$build/bin/cournand" "$@" \
        >"$folder/output" 2>&1 && grep -q -e "$text" "$folder/output"; then
        echo "ok $count - $name"
        grep -e 'reports in' -e 'wall clock' "$folder/output" | sed 's/^/# /'
    else
        status=1
        echo "not ok $count - $name"
        sed 's/^/# /' "$folder/output"
    fi
}

echo "advance 25 mm at 40 mm/s" >"$folder/a.session"
wire=shared/examples/instruments/j_wire.toml
hash=$("$build/bin/cournand" run --quiet --instrument $wire --session "$folder/a.session" | sed -n 's/^final hash *//p')

expect rig_list_shows_version_and_state 'READY' rig list
expect rig_info_reads_the_configuration 'limits *8.000 N' rig info --device usb
expect rig_log_reads_the_fault_log 'no faults' rig log
expect rig_monitor_by_hidraw 'reports in' rig monitor --seconds 1 --hid hidraw
expect rig_monitor_by_libusb 'reports in' rig monitor --seconds 1 --hid libusb
expect a_session_has_the_hash_of_the_sim "final hash *${hash:-none}" run --quiet --device usb --instrument $wire \
    --session "$folder/a.session"

# The image on an emulated Cortex-M7, with the rig around it, replaces the app in a process.
plain="${build%/san}"
count=$((count + 1))
if "$plain/bin/hil_rig" --live -- env ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD="$preload" timeout 60 \
    "$build/hil/mock_bus" --mailbox '{mailbox}' -- \
    "$build/bin/cournand" run --quiet --device usb --instrument $wire --session "$folder/a.session" \
    >"$folder/output" 2>&1 &&
    grep -q -e "final hash *${hash:-none}" "$folder/output"; then
    echo "ok $count - a_session_on_the_image_has_the_hash_of_the_sim"
else
    status=1
    echo "not ok $count - a_session_on_the_image_has_the_hash_of_the_sim"
    sed 's/^/# /' "$folder/output"
fi
echo "1..$count"
exit $status
