#!/usr/bin/env bash
# The core computes the same bits whatever compiles it: tools/check/core_hash.c built three ways prints the hashes of
# tools/check/core_hash.golden. Two of the three contain the core's library from the build: the one that ships (gcc
# -O3), and the one of the sanitized tests (clang -O2). With the word `others` it is built three other ways, and must
# print the same hashes. Prints TAP. Other machines: test_matrix.py and `make matrix`. The whole host program:
# compare_compilers.sh (make compilers).
set -uo pipefail
cd "$(dirname "$0")/../../.." || exit 1
built="${CRN_SHIPPED:-${BUILD:-build}}"
library="$built/lib/libfirmware_core.a"
sanitized="$built/san/lib/libfirmware_core.a"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT

count=0
failed=0
report() { # report STATUS NAME [FILE]
    count=$((count + 1))
    if [ "$1" = 0 ]; then echo "ok $count - $2"; else
        failed=1
        echo "not ok $count - $2"
        [ -z "${3:-}" ] || sed 's/^/# /' "$3"
    fi
}

build() { # build NAME CORE COMPILER FLAGS...: CORE is `sources`, or a library of the build
    local name="$1" core="$2"
    shift 2
    [ "$core" != sources ] || core="$(echo firmware/core/*.c firmware/core/{near,wall}/*.c)"
    # shellcheck disable=SC2086
    "$@" -std=c11 -I. tools/check/core_{hash,scenes}.c tools/check/console_stdio.c $core \
        -o "$folder/$name" \
        >"$folder/log" 2>&1
}

compare() { # compare TITLE CORE COMPILER FLAGS...
    local title="$1"
    shift
    if build variant "$@"; then
        "$folder/variant" >"$folder/got" 2>&1
        diff tools/check/core_hash.golden "$folder/got" >"$folder/log" 2>&1
    else
        false
    fi
    report $? "$title gives the hashes of tools/check/core_hash.golden" "$folder/log"
}

if [ "${1:-}" = others ]; then
    compare "gcc -O0" sources gcc -O0
    compare "gcc -Os" sources gcc -Os
    compare "clang -O1 with the undefined-behaviour sanitizer" sources \
        clang -O1 -fsanitize=undefined -fno-sanitize-recover=all
    echo "1..$count"
    exit $failed
fi

build reference sources gcc -O2
report $? "the hash program builds with gcc -O2" "$folder/log"
"$folder/reference" >"$folder/expected" 2>&1
report $? "the hash program runs" "$folder/expected"

# A golden hash changes only in a commit whose message says why the physics changed; then write it anew with
# gcc -std=c11 -O2 -I. firmware/core/{,*/}*.c tools/check/core_{hash,scenes}.c tools/check/console_stdio.c -o hash
# ./hash > tools/check/core_hash.golden
diff tools/check/core_hash.golden "$folder/expected" >"$folder/log" 2>&1
report $? "the hashes are those of tools/check/core_hash.golden" "$folder/log"

"$folder/reference" variant 1 >"$folder/other" 2>&1 && ! cmp -s "$folder/expected" "$folder/other"
report $? "a hand that turns one unit in 2^32 more per tick gives another hash"

contacts="$(sed -n 's/^tube contacts_max \([0-9]*\).*/\1/p' "$folder/expected")"
[ "${contacts:-0}" -ge 10 ]
report $? "the session has at least 10 contacts at once (${contacts:-none})"

compare "the library that ships, gcc -O3" "$library" gcc -O3
compare "the library with the sanitizers, clang -O2" "$sanitized" clang -O2 -fsanitize=address,undefined
echo "1..$count"
exit $failed
