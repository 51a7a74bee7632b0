#!/usr/bin/env bash
# A build folder keeps the values of its preset, such as the sanitizers, when the path to the compiler changes. The path
# changes, for example, when ccache's folder of compilers is put first into PATH. Prints TAP.
set -u
cd "$(dirname "$0")/../../.." || exit 1
programs="" # it builds none
# shellcheck source=tools/check/tool.sh
. tools/check/tool.sh
export BUILD="$work/build"
for compiler in clang clang++; do
    mkdir -p "$work/other"
    # A link of ccache would look for the compiler in PATH again, and find this one.
    real=$(type -ap $compiler | grep -v /ccache/ | head -n 1)
    printf '#!/bin/sh\nexec "%s" "$@"\n' "$real" >"$work/other/$compiler"
    chmod +x "$work/other/$compiler"
done
configured() { # PARTS: configures the folder for sanitizers, and checks the sanitizers and the parts
    tools/build.sh sanitize "$1" build.ninja >"$work/said" 2>&1 &&
        grep -q '^CRN_SANITIZE:STRING=address,undefined$' "$BUILD/san/CMakeCache.txt" &&
        grep -q "^CRN_PARTS:[A-Z]*=.*$1" "$BUILD/san/CMakeCache.txt"
}
configured run
report "a new folder is configured by its preset" $?
PATH="$work/other:$PATH" configured tests
report "it keeps the preset when the path to the compiler changes" $?
if CMAKE_ARGS=-DCMAKE_CXX_COMPILER=no-such-compiler tools/build.sh sanitize run build.ninja >"$work/said" 2>&1; then
    report "a configuration that fails is reported" 1
else
    grep -q no-such-compiler "$work/said"
    report "a configuration that fails is reported" $?
fi
echo "1..$number"
exit $failed
