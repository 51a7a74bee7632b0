# Sourced by the shell tests of the program, at the repository's root: $program is built and absolute, and
# $work is a folder that is removed at the end. `result` prints a line of TAP for the last command's exit
# status, with the end of $log when it failed.
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)"
build="$root/${BUILD:-build}"
program="$build/bin/cournand"
work="$(mktemp -d)"
log="$work/log"
trap 'rm -rf "$work"' EXIT
: >"$log"
number=0 failed=0
result() { # status, name
    number=$((number + 1))
    if [ "$1" = 0 ]; then echo "ok $number - $2"; else
        echo "not ok $number - $2"
        failed=1
        tail -n 12 "$log" | sed 's/^/# /'
    fi
}
cd "$root" || exit 1
[ -x "$program" ] || { echo "Bail out! $program is not built: tools/build.sh release run cournand"; exit 1; }
