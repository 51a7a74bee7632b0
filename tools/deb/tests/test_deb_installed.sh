#!/usr/bin/env bash
# The Debian packages are installed into a bare Debian 12 that mmdebstrap makes, used there and purged: the programs,
# the library from C and by CMake, and the Python module. It takes minutes and needs the network, so it has the label
# `hours`. A user who is not root needs the right to make user namespaces. Prints TAP (bare.sh).
set -u
cd "$(dirname "$0")/../../.." || exit 1
programs="cournand anatomy bake centreline"
# shellcheck source=tools/check/tool.sh
. tools/check/tool.sh
chmod 755 "$work"
given=$work/packages
fail() {
    echo "1..1"
    echo "not ok 1 - $1"
    sed 's/^/# /' "$work/said"
    exit 1
}
tools/deb/make_packages.py --build "$BUILD" --output "$given" >"$work/said" 2>&1 || fail "the packages are made"
XDG_CACHE_HOME=$work/cache "$tool" run demo --quiet 2>"$work/said" | grep '^final hash' >"$given/expected" ||
    fail "the program of the build folder runs the session demo"
sed -n '/^```python$/,/^```$/p' README.md | grep -v '^```' >"$given/five_lines.py"
for file in host/python/tests/{prepare,test_python_api}.py tools/check/{tap,tree,pinned_environment}.py; do
    install -D -m 644 "$file" "$given/tests/$file"
done
cp tools/deb/tests/bare.sh "$given"
# The commands with $1 run in mmdebstrap's own shell, where it is the folder of the bare Debian.
# shellcheck disable=SC2016
mmdebstrap --quiet --variant=minbase --customize-hook="copy-in $given /" \
    --customize-hook='chroot "$1" bash /packages/bare.sh >"$1/packages/tap" 2>"$1/packages/errors" || true' \
    --customize-hook="copy-out /packages/tap /packages/errors $work" bookworm /dev/null >"$work/said" 2>&1 ||
    fail "mmdebstrap makes a bare Debian 12 and runs the checks in it"
sed 's/^/# /' "$work/errors"
cat "$work/tap"
! grep -q '^not ok' "$work/tap" && grep -q '^1\.\.' "$work/tap"
