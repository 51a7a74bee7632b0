# Sourced by the shell tests of the tools, at the repository's root, with the programs' names in $programs: they are
# built, $tool is the first, $here the test's folder, $work a folder that goes away at the end. `report` prints a line
# of TAP.
BUILD=${BUILD:-build}
here=$(dirname "$0")
tool=$BUILD/bin/${programs%% *}
for program in $programs; do
    [ -x "$BUILD/bin/$program" ] || {
        echo "1..1"
        echo "not ok 1 - $BUILD/bin/$program is not built (ninja -C $BUILD $program)"
        exit 1
    }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
number=0

report() { # report NAME STATUS: what the last program said, left in $work/said, stands below a failure
    number=$((number + 1))
    [ "$2" = 0 ] && echo "ok $number - $1" && return
    echo "not ok $number - $1"
    failed=1
    [ ! -f "$work/said" ] || sed 's/^/# /' "$work/said"
}

# refuses NAME EXIT_CODE WORDS ARGUMENTS...: the command ends with the code and its message holds the words
refuses() {
    name=$1 code=$2 words=$3
    shift 3
    "$tool" "$@" >"$work/said" 2>&1
    got=$?
    [ "$got" = "$code" ] && grep -q -- "$words" "$work/said"
    result=$?
    report "$name" "$result"
    [ "$result" = 0 ] || echo "# exit $got, expected $code with '$words'"
}
