#!/usr/bin/env bash
# Linux' module usbtest against the USB stack of the device (docs/usb.md, "The kernel's own judge"): runs its cases in
# the guest of level L3, prints a row of TAP for each, and a sum at the end. Run it from the root of the tree.
#
#   usbtest.sh [--case N | --times N] RUN...
#
# RUN is DEVICE:CONTROLLER[:CABLE]; without a RUN, all that are listed below run. --case N runs one case alone, and
# --times N runs all with N times as many transfers.
# DEVICE is `image` (source and sink on the emulated Cortex-M7), `board` (the same in the board's image on its emulated
# chip), `rig` (the device as it ships) or `beside` (the same while a session runs over its stream). CONTROLLER is that
# of the guest, `xhci` or `ehci`. CABLE is `full-speed`, or `lossy`: every 7th acknowledgement in each direction is
# lost, so that the packet is sent again. The figures of a call without arguments go to out/hil_usbtest.tsv. BUILD names
# the build folder.
set -uo pipefail
build=${BUILD:-build}
hil=$build/hil
runs=(image:xhci image:ehci image:xhci:full-speed image:ehci:lossy
    board:xhci board:ehci board:xhci:full-speed board:ehci:lossy rig:xhci beside:xhci beside:ehci)
options=()
figures=out/hil_usbtest.tsv
if [ "${1:-}" = --case ] || [ "${1:-}" = --times ]; then
    options=("$1" "${2:?a number is missing}")
    shift 2
    figures=
fi
if [ $# -gt 0 ]; then runs=("$@") figures=; fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# one DEVICE CONTROLLER CABLE: prints the rows of one guest
one() {
    local beside
    local -a extra=("${options[@]}") guest=(hil_tests/l3/run_guest.py --bridge "$hil/bridge" --kernel "$hil/kernel"
        --seconds "${LIMIT:-180}" --controller "$2")
    case $1 in
    image) beside=("$build/bin/hil_rig" --live --image "$build/firmware/usbtest-mps2_an500.elf") ;;
    board) beside=("$hil/hil_rt1062" --image "$build/firmware/usbtest-imxrt1062.elf") ;;
    rig) beside=("$build/bin/hil_rig" --live) && extra+=(--rig) ;;
    beside) beside=("$build/bin/hil_rig" --live) && extra+=(--beside "$hil/app_check") ;;
    *) echo "usbtest.sh: '$1' is no device: image, board, rig or beside" >&2 && return 2 ;;
    esac
    [ -z "$3" ] || guest+=(--cable "$3")
    "${beside[@]}" -- "${guest[@]}" --mailbox '{mailbox}' -- "$hil/usbtest" "$hil/kernel/usbtest.ko" "${extra[@]}"
}

count=0
failed=0
applied=0
for run in "${runs[@]}"; do
    IFS=: read -r device controller cable <<<"$run"
    one "$device" "$controller" "${cable:-}" >"$log" 2>&1
    status=$?
    # The rows of all runs are numbered through; a plan per run would be none of the whole.
    sed -e '/^1\.\./d' -e '/^\(not \)\?ok [0-9]/!s/^\([^#]\)/# \1/' "$log" |
        awk -v from="$count" -v run="$run" '
            /^(not )?ok [0-9]/ { sub(/ok [0-9]+ - /, "ok " ++from " - " run ", ") }
            { print }'
    rows=$(grep -cE '^(not )?ok [0-9]' "$log")
    lost=$(grep -cE '^not ok [0-9]' "$log")
    # A guest that ended without a plan has lost rows that nobody counted.
    if ! grep -q '^1\.\.' "$log" || { [ "$status" != 0 ] && [ "$lost" = 0 ]; }; then
        rows=$((rows + 1)) lost=$((lost + 1))
        echo "not ok $((count + rows)) - $run, the run comes to its end (exit code $status)"
    fi
    count=$((count + rows)) failed=$((failed + lost))
    applied=$((applied + $(grep -E '^ok [0-9]+ - case' "$log" | grep -cv 'does not apply')))
done
echo "1..$count"
echo "# usbtest: $applied cases passed in ${#runs[@]} runs, $failed rows failed"
if [ -n "$figures" ]; then
    mkdir -p out
    printf 'hil.usbtest_cases_passed\t%d\nhil.usbtest_rows_failed\t%d\n' "$applied" "$failed" >"$figures"
fi
[ "$failed" = 0 ] && [ "$count" -gt 0 ]
