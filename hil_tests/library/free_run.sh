#!/bin/sh
# A session that the rig leads, with power, by the unmodified program cournand. The stream's ticks and shapes come by
# libusb, and beside it the state of every millisecond comes by hidapi. It needs a rig that moves by itself (hil_rig
# --live), or hands. Prints TAP.
#   free_run.sh SECONDS FOLDER      the recording is left in FOLDER
build="${BUILD:-build}"
seconds="$1"
folder="$2"
device="usb${RIG_SERIAL:+:$RIG_SERIAL}"
count=0
status=0

verdict() {
    count=$((count + 1))
    [ "$1" = 0 ] && echo "ok $count - $2" && return
    status=1
    echo "not ok $count - $2"
}

"$build/bin/cournand" rig calibrate --device "$device" --load hil_tests/rig/plant.json --yes >"$folder/rig.log" 2>&1
verdict $? the_rig_takes_the_couplings_of_the_plant
# The program that monitors every millisecond has priority where a machine, or its emulation, is short of time.
urgent=""
chrt -f 10 true 2>/dev/null && urgent="chrt -f 10"
$urgent "$build/bin/cournand" rig monitor --device "$device" --seconds "$seconds" >"$folder/monitor.log" 2>&1 &
"$build/bin/cournand" run --quiet --device "$device" --scene "${AORTA_SCENE:-out/aorta.scene}" \
    --tool shared/examples/instruments/j_wire.toml \
    --free-run "$seconds" --motors --yes --fps 60 --record "$folder/free_run.rec" >"$folder/run.log" 2>&1
verdict $? the_session_reaches_its_end
wait
sed -n 's/^led by the rig */#- /p' "$folder/run.log"
tail -1 "$folder/monitor.log" | sed 's/^/#- HID: /'
grep -e '^ticks' -e '^final' -e '^led' -e '^device' -e 'inserted  ' -e 'hand force' "$folder/run.log" | sed 's/^/# /'
# A lost tick makes the host go back and resume, so there must be none.
grep -q '^led by the rig' "$folder/run.log" && ! grep -q -e 'came back' -e TICKS_LOST "$folder/run.log"
verdict $? no_tick_of_the_stream_is_lost
# This is judged where the machine keeps real time, for an emulated rig too, because a rig's milliseconds do not wait.
# $STRICT judges it always.
came=$(sed -n 's/^\([0-9]*\) reports in.*/\1/p' "$folder/monitor.log")
lost=$(sed -n 's/^.* s, \([0-9]*\) ticks lost.*/\1/p' "$folder/monitor.log")
skip=""
if [ -z "$STRICT" ] && [ "${lost:-1}" != 0 ] && [ "$((came + lost))" -gt 0 ] &&
    [ "$((came + lost))" -lt $((seconds * 990)) ]; then
    skip=" # SKIP this machine made $((came + lost)) ms of the rig in $seconds s"
    echo "#- NOT JUDGED: HID, since$skip" | sed 's/ # SKIP//'
    lost=0
fi
[ "${lost:-1}" = 0 ]
verdict $? "no_tick_of_the_state_reports_is_lost$skip"
[ $status = 0 ] || sed 's/^/# /' "$folder"/*.log
echo "1..$count"
exit $status
