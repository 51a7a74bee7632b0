#!/usr/bin/env bash
# The cases of hil_tests/cases with the board's image on the emulated chip (docs/rt1062.md). Prints TAP.
set -euo pipefail
cd "$(dirname "$0")/../../.."
build=${BUILD:-build}
exec "$build/hil/hil_rt1062" --image "$build/firmware/cournand-imxrt1062.elf"
