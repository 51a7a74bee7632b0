#!/usr/bin/env bash
# Measures the lines that the product's tests run, by clang's source-based coverage: out/coverage.tsv. BUILD and JOBS
# are as in the Makefile.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=${BUILD:-build}/coverage
export JOBS=${JOBS:-$(nproc)} KEEP_GOING=1
tools/build.sh coverage run,tools,tests crn_tests || exit 1
BUILD=${BUILD:-build} tools/build.sh m7 run all || exit 1
# test_compilers.sh, test_matrix.py and test_objects.py look at the core as it ships, without the counters of coverage.
export CRN_SHIPPED=${BUILD:-build}
tools/build.sh release run crn_firmware_core || exit 1
tools/build.sh sanitize run,tests crn_firmware_core || exit 1
rm -rf "$build/profiles"
mkdir -p "$build/profiles" "$build/firmware"
cp "${BUILD:-build}"/firmware/*.elf "$build/firmware/"
# test_image.py reads the objects of the images, which the preset `m7` has built.
ln -sfn "$(realpath "${BUILD:-build}")/m7" "$build/m7"
# test_l2.sh runs the programs of the sanitized build, which are the same programs here.
ln -sfn . "$build/san"
# A failed test is named, and the lines that it ran are counted nevertheless.
LLVM_PROFILE_FILE="$PWD/$build/profiles/%p-%m.profraw" \
    tools/check/run_tests.py --build "$build" --jobs "$JOBS" --label product
tools/check/coverage.py --build "$build" --profiles "$build/profiles" \
    --programs $(find "$build/test" "$build/bin" -type f -perm -u+x)
