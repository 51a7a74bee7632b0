#!/usr/bin/env bash
# A build folder keeps the values of its preset, such as the sanitizers, when the path to the compiler changes. The path
# changes, for example, when ccache's folder of compilers is put first into PATH. Precompiled headers, which are used
# where there is no ccache, fit the code that includes them. Prints TAP.
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
# gcc accepts a precompiled header only where addresses (-fPIC, -fPIE) and visible symbols are compiled in the same way.
export CMAKE_ARGS=-DCRN_PREFIX_HEADERS=ON BUILD="$work/prefix"
tools/build.sh release run,tools,tests build.ninja >"$work/said" 2>&1 &&
    python3 - "$work/prefix/compile_commands.json" >"$work/said" 2>&1 <<'PYTHON'
import json, re, sys
uses, kinds = 0, {}
for entry in json.load(open(sys.argv[1])):
    header = re.search(r"[^ ]*/cmake_pch\.hxx", entry["command"])
    if header:
        uses += 1
        flags = re.findall(r" (-f(?:no-)?(?:PIC|PIE|pic|pie)|-fvisibility=\w+|-O\w)\b", entry["command"])
        kinds.setdefault(header[0], set()).add(tuple(sorted(flags)))
print("%d commands with precompiled headers" % uses, *kinds.items(), sep="\n")
sys.exit(0 if uses > 100 and all(len(kind) == 1 for kind in kinds.values()) else 1)
PYTHON
report "a precompiled header, and all code that includes it, are compiled with the same flags" $?
echo "1..$number"
exit $failed
