#!/usr/bin/env bash
# Joins archives to one static library, in which only the functions of two headers are visible.
# usage: static_library.sh HEADER MORE LIBRARY ARCHIVE...
# The linker joins what these functions reach to one object, and objcopy hides all other names. A program that links the
# library can therefore have any names of its own, and needs none of the libraries for parts that were dropped.
set -euo pipefail
headers=("$1" "$2") library=$3
shift 3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat "${headers[@]}" | tr '\n' ' ' | grep -oE 'COURNAND_API [^;(]*\(' |
    grep -oE 'cournand_[a-z0-9_]+\(' | tr -d '(' >"$work/names"
[ -s "$work/names" ]
mapfile -t wanted < <(sed 's/^/--undefined=/' "$work/names")
ld.bfd -r --gc-sections --force-group-allocation "${wanted[@]}" -o "$work/cournand.o" --start-group "$@" --end-group
objcopy --strip-debug --keep-global-symbols="$work/names" "$work/cournand.o"
rm -f "$library"
ar rcsD "$library" "$work/cournand.o"
