#!/usr/bin/env bash
# Tests that the threads of a live session and of a replay share nothing without a lock: their tests run under gcc's
# thread sanitizer, in a build of their own.
set -u
. "$(dirname "$0")/../../app/tests/program.sh"
folder=$build/thread
cmake --preset sanitize-gcc -B "$folder" -DCRN_SANITIZE_GCC=thread "-DCRN_PARTS=run;window;tools;tests" >"$log" 2>&1 &&
    ninja -C "$folder" test_host_live_tests_test_threads test_host_live_tests_test_replay_room >>"$log" 2>&1
result $? "the tests of the threads build with the thread sanitizer"
for test in test_threads test_replay_room; do
    TSAN_OPTIONS="halt_on_error=1 second_deadlock_stack=1" "$folder/test/host/live/tests/$test" >"$log" 2>&1
    result $? "$test runs without a race"
done
echo "1..$number"
exit $failed
