#!/bin/sh
# Level L2 with the program, libusb's and hidapi's callers and the device under the sanitizers. Prints TAP.
export CRN_IMAGE="${CRN_IMAGE:-${BUILD:-build}/firmware/cournand-mps2_an500.elf}"
BUILD="${BUILD:-build}/san" exec "$(dirname "$0")/test_l2_rig.sh"
