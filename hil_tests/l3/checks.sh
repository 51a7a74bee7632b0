#!/bin/sh
# It runs inside the guest of level L3, from the root of the tree: the host's own libraries access the device on the
# guest's USB. The exit code is 0 only when that of every program is 0.
folder="${HIL:-build/hil}"
status=0
for program in usb_check hid_check_hidraw hid_check_libusb; do
    echo "# $program"
    "$folder/$program" || status=1
done
exit $status
