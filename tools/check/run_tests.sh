#!/usr/bin/env bash
# Builds and runs tests: run_tests.sh product|lab|hours|build. A program that does not build is reported as failed,
# and all other tests still run. BUILD and JOBS are as in the Makefile. `build` only builds the programs that the
# product's tests need.
set -uo pipefail
cd "$(dirname "$0")/../.."
what=$1
build=${BUILD:-build}
export KEEP_GOING=1 JOBS=${JOBS:-$(nproc)}
status=0
begin=$SECONDS
note() { echo "$1: $((SECONDS - begin)) s"; }
if [ "$what" = lab ]; then
    tools/build.sh release run,tools,tests,lab crn_tests_lab || status=1
    tools/build.sh m7 run all usbtest-mps2_an500 || status=1
    tools/build.sh sanitize run,tests crn_tests_lab cournand hil_programs || status=1
elif [ "$what" = hours ]; then
    tools/build.sh release run,tools,tests,lab cournand anatomy bake centreline cournand_library peer_moving || status=1
else
    tools/build.sh release run,tools,tests crn_tests || status=1
    tools/build.sh m7 run all || status=1
    tools/build.sh sanitize run,tests crn_tests crn_fuzzers_product hil_programs || status=1
fi
note "built"
[ "$what" = build ] && exit $status
tools/check/run_tests.py --build "$build" --jobs "$JOBS" --label "$what" || status=1
note "make test$([ "$what" = product ] || echo "-$what")"
[ $status = 0 ] || echo "something did not build or failed, see above" >&2
exit $status
