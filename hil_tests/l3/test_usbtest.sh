#!/usr/bin/env bash
# The kernel's module usbtest against the USB stack in the emulated Cortex-M7 (docs/usb.md): the controller with which
# most cases run. `make hil-usbtest` runs all. Prints TAP.
exec "$(dirname "$0")/usbtest.sh" image:ehci
