#!/usr/bin/env bash
# The whole program computes the same bits with any compiler. `cournand replay RECORDING --verify` prints the same
# final hash when built by gcc -O0, gcc -O3 and clang -O2, and at any speed. The X-ray picture of
# host/xray/tests/test_xray.cpp has one hash with 1, 2, 3 and 7 threads. `make compilers` calls this script, which
# takes minutes: it builds three programs (build/compilers/NAME) and plays the recording in real time. usage:
# compare_compilers.sh [RECORDING]     default: out/demo.rec, as `make run` leaves it
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
recording="${1:-out/demo.rec}"
jobs="${JOBS:-$(nproc)}"
if [ $# -gt 1 ]; then
    echo "usage: $0 [RECORDING]" >&2
    exit 2
fi
if [ ! -f "$recording" ]; then
    echo "compare_compilers: $recording does not exist: run \`make run\` first, or name a recording" >&2
    exit 1
fi

hashes=()
pictures=()
replay() { # replay TITLE PROGRAM OPTIONS...
    local title="$1" program="$2" output hash
    shift 2
    if ! output="$("$program" replay "$recording" --verify "$@" </dev/null 2>&1)"; then
        printf '%-24s FAILED: %s\n' "$title" "$output"
        exit 1
    fi
    hash="$(sed -n 's/^final hash //p' <<<"$output")"
    if [ -z "$hash" ]; then
        printf '%-24s FAILED: no final hash in: %s\n' "$title" "$output"
        exit 1
    fi
    printf '%-24s %s\n' "$title" "$hash"
    hashes+=("$hash")
}

picture() { # picture TITLE PROGRAM
    local output hash
    output="$("$2" 2>&1)"
    hash="$(sed -n 's/^# hash //p' <<<"$output")"
    if [ -z "$hash" ]; then
        printf '%-24s FAILED: no hash of a picture in: %s\n' "$1" "$output"
        exit 1
    fi
    printf '%-24s %s\n' "$1 picture" "$hash"
    pictures+=("$hash")
}

variant() { # variant NAME CC CXX LEVEL
    local build="build/compilers/$1"
    export CMAKE_ARGS="-DCMAKE_C_COMPILER=$2 -DCMAKE_CXX_COMPILER=$3 -DCRN_OPT=$4 -DCRN_CORE_OPT=$4"
    echo "building $1 ..."
    if ! BUILD="$build" JOBS="$jobs" tools/build.sh release run,tools,tests cournand test_host_xray_tests_test_xray \
        >"build/compilers-$1.log" 2>&1; then
        tail -n 20 "build/compilers-$1.log" >&2
        echo "compare_compilers: $1 does not build; the whole log is build/compilers-$1.log" >&2
        exit 1
    fi
    replay "$1" "$build/bin/cournand"
    picture "$1" "$build/test/host/xray/tests/test_xray"
}

mkdir -p build
variant gcc-O0 gcc g++ -O0
variant clang-O2 clang clang++ -O2
variant gcc-O3 gcc g++ -O3
for speed in slow paused 1; do
    replay "gcc-O3 --speed $speed" build/compilers/gcc-O3/bin/cournand --speed "$speed"
done

for hash in "${pictures[@]}"; do
    if [ "$hash" != "${pictures[0]}" ]; then
        echo "the hashes of the picture differ" >&2
        exit 1
    fi
done
for hash in "${hashes[@]}"; do
    if [ "$hash" != "${hashes[0]}" ]; then
        echo "the hashes differ" >&2
        exit 1
    fi
done
echo "all ${#hashes[@]} hashes agree, and ${#pictures[@]} of the picture"
