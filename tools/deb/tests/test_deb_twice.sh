#!/usr/bin/env bash
# Debian packages of a second build, in another folder and without a compiler cache, have the same bytes as those of the
# build folder. It compiles for ten minutes on two processors, so it has the label `hours`. Prints TAP.
set -u
cd "$(dirname "$0")/../../.." || exit 1
programs="cournand anatomy bake centreline"
# shellcheck source=tools/check/tool.sh
. tools/check/tool.sh
# Both builds have the same version and date, also where there are changes that are not committed.
export GIT_DIR="$work/none" SOURCE_DATE_EPOCH=1700000000
other=$work/a_folder_with_a_longer_name/cournand
mkdir -p "$other"
env -u GIT_DIR git ls-files -co --exclude-standard -z | xargs -0 cp --parents -t "$other"
tools/deb/make_packages.py --build "$BUILD" --output "$work/first" >"$work/said" 2>&1
report "packages are made of the build folder" $?
(
    cd "$other" && unset BUILD && export CCACHE_DISABLE=1
    tools/build.sh release run,tools cournand anatomy bake centreline cournand_library &&
        tools/deb/make_packages.py --output "$work/second"
) >"$work/said" 2>&1
report "packages are made of a copy in another folder" $?
(cd "$work" && diff -r first second) >"$work/said" 2>&1
report "all packages have the same bytes" $?
echo "1..$number"
exit $failed
