#!/usr/bin/env bash
# Builds targets of a CMake preset. It configures if necessary, and prints nothing if everything is up to date.
# usage: build.sh PRESET PARTS TARGET...
# PARTS (run, window, igtl, tools, tests, lab, separated by commas) are added to the parts for which the folder is
# configured. So `make run` needs no package of the tests, and a later `make test` continues in the same folder. BUILD
# names another folder, JOBS the number of parallel compilers; CMAKE_ARGS is passed to cmake. V=1 shows whole commands.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1 parts=$2
shift 2
case $preset in
    release) folder=${BUILD:-build} ;;
    sanitize) folder=${BUILD:-build}/san ;;
    *) folder=${BUILD:-build}/$preset ;;
esac
cache=$folder/CMakeCache.txt
have=$(sed -n 's/^CRN_PARTS:STRING=//p' "$cache" 2>/dev/null || true)
want=$have
for part in ${parts//,/ }; do [[ ";$want;" == *";$part;"* ]] || want=${want:+$want;}$part; done
if [ ! -e "$folder/build.ninja" ] || [ "$want" != "$have" ] || [ -n "${CMAKE_ARGS:-}" ]; then
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    # shellcheck disable=SC2086
    configure() { cmake --preset "$preset" -B "$folder" "-DCRN_PARTS=$want" ${CMAKE_ARGS:-} >"$log" 2>&1; }
    # When the path to the compiler has changed, CMake deletes its cache and forgets the preset's values, such as the
    # sanitizers, and the parts; it may then miss packages that these parts do not need. The second call sets them.
    made=0
    configure || made=$?
    if grep -q 'cache to be deleted' "$log"; then made=0 && { configure || made=$?; }; fi
    [ "$made" = 0 ] || {
        cat "$log" >&2
        exit 1
    }
fi
quiet=--quiet
[ ! -t 1 ] || quiet= # a person sees how far it is, in one line
exec ninja -C "$folder" ${JOBS:+-j "$JOBS"} ${KEEP_GOING:+-k 0} ${V:+-v} $quiet "$@"
