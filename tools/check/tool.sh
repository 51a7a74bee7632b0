# The shell tests of the tools source this file at the repository's root, with the programs' names in $programs. It
# builds the programs; $tool is the first, $here is the test's folder, and $work is a folder that is removed at the
# end. `report` prints a line of TAP.
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

report() { # report NAME STATUS: below a failure it prints the last program's output, stored in $work/said
    number=$((number + 1))
    [ "$2" = 0 ] && echo "ok $number - $1" && return
    echo "not ok $number - $1"
    failed=1
    [ ! -f "$work/said" ] || sed 's/^/# /' "$work/said"
}

# refuses NAME EXIT_CODE WORDS ARGUMENTS... checks that the command ends with the code and its message contains the
# words.
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
