#!/usr/bin/env bash
# tools/check/install_packages.sh reports errors, asks, and installs only requested packages. The test uses a copy in
# a temporary folder whose list names packages that are installed or do not exist, and an apt-get that only records
# its requests. Prints TAP.
set -uo pipefail
cd "$(dirname "$0")/../../.." || exit 1
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder/tools/check" "$folder/bin"
cp tools/check/install_packages.sh "$folder/tools/check/"
printf '# list\n[here]\nbash\nmake\n\n[gone]\nno-such-package-cournand\n' >"$folder/tools/packages.txt"
install="$folder/tools/check/install_packages.sh"

count=0
failed=0
expect() { # expect CODE TEXT NAME COMMAND...
    local code="$1" text="$2" name="$3" got
    shift 3
    count=$((count + 1))
    output="$("$@" 2>&1)"
    got=$?
    if [ "$got" = "$code" ] && [[ "$output" == *"$text"* ]]; then echo "ok $count - $name"; else
        failed=1
        echo "not ok $count - $name"
        printf '# exit code %s, expected %s; expected the text "%s" in:\n' "$got" "$code" "$text"
        sed 's/^/# /' <<<"$output"
    fi
}

expect 2 "no section [other]" "an unknown section is a usage error" "$install" other
expect 0 "" "a section whose packages are all there ends at once" "$install" here

# A dpkg-query that knows no package, on a machine without root and sudo: nothing can be installed.
for tool in bash grep awk sort dirname id cat; do ln -s "$(command -v $tool)" "$folder/bin/$tool"; done
expect 1 "This is not a Debian system" "another system gets the list and a stop" \
    env PATH="$folder/bin" "$install" here gone
expect 1 "no-such-package-cournand" "the list names every package" env PATH="$folder/bin" "$install" gone
rm "$folder/bin/id"
printf '#!/bin/bash\nexit 1\n' >"$folder/bin/dpkg-query"
printf '#!/bin/bash\necho 1000\n' >"$folder/bin/id"
chmod +x "$folder/bin/dpkg-query" "$folder/bin/id"
expect 1 "Neither root nor sudo" "without root and sudo it says what to do" env PATH="$folder/bin" "$install" gone

# Root on a Debian where one package is missing, with an apt-get that knows how large it is and installs on paper.
rm "$folder/bin/dpkg-query" "$folder/bin/id"
for tool in sed mktemp rm env tail flock cat; do ln -sf "$(command -v $tool)" "$folder/bin/$tool"; done
printf '#!/bin/bash\nexit 1\n' >"$folder/bin/dpkg-query"
printf '#!/bin/bash\necho 0\n' >"$folder/bin/id"
cat >"$folder/bin/apt-get" <<END
#!/bin/bash
case "\$*" in
*--print-uris*)
    [ ! -e "$folder/no-lists" ] || exit 100
    echo "0 upgraded, 3 newly installed, 0 to remove and 118 not upgraded."
    echo "Need to get 12.3 MB of archives."
    echo "After this operation, 45.6 MB of additional disk space will be used."
    ;;
update*) echo "update" >>"$folder/asked"; rm -f "$folder/no-lists" ;;
*) echo "install \${*: -1}" >>"$folder/asked" ;;
esac
END
chmod +x "$folder/bin/"{dpkg-query,id,apt-get}
asked() { cat "$folder/asked" 2>/dev/null; rm -f "$folder/asked"; }
is_asked() { # is_asked NAME WHAT: checks the requests to apt-get since the last time
    count=$((count + 1))
    got="$(asked)"
    if [ "$got" = "$2" ]; then echo "ok $count - $1"; else
        failed=1
        echo "not ok $count - $1"
        printf '# apt-get was asked for "%s", expected "%s"\n' "$got" "$2"
    fi
}
root() { env -u YES -u CI PATH="$folder/bin" "$@"; }
# The same with a terminal, on which ANSWER is typed.
terminal() { local answer="$1"; shift; printf '%s\n' "$answer" |
    timeout 20 script -qefc "env -u YES -u CI PATH=$folder/bin $*" /dev/null; }
install_both=$'update\ninstall no-such-package-cournand'

expect 1 "no terminal to ask on" "without a terminal nothing is installed, and it says so" root "$install" gone \
    </dev/null
is_asked "not even the lists are fetched" ""
expect 1 "YES=1 make test" "it says what to type instead" root MAKE_GOALS=test "$install" gone </dev/null
expect 1 "apt-get install --no-install-recommends no-such-package-cournand" "and which command would do it" root \
    "$install" gone </dev/null
asked >/dev/null
expect 0 "45.6 MB of additional disk space" "YES=1 installs and says how much" root YES=1 "$install" gone </dev/null
is_asked "YES=1 has it installed" "$install_both"
expect 0 "Need to get 12.3 MB" "CI=true counts as a machine that says yes" root CI=true "$install" gone </dev/null
is_asked "CI=true has it installed" "$install_both"
expect 1 "no terminal to ask on" "CI=false is no answer" root CI=false "$install" gone </dev/null
expect 0 "Install them with apt-get? [Y/n]" "on a terminal it asks, Enter is yes" terminal "" "$install" gone
is_asked "after the answer it is installed" "$install_both"
expect 1 "Nothing was installed." "n on the terminal ends it" terminal n "$install" gone
is_asked "and nothing was installed" ""
expect 0 "12.3 MB" "the question comes after the names and the amount" terminal y "$install" gone
count=$((count + 1))
if [[ "$output" == *no-such-package-cournand*"45.6 MB"*"[Y/n]"* ]]; then echo \
    "ok $count - names, amount, question, in this order"; else
    failed=1
    echo "not ok $count - names, amount, question, in this order"
    sed 's/^/# /' <<<"$output"
fi
asked >/dev/null
touch "$folder/no-lists"
expect 0 "not known here before the package lists" "without package lists it says that the amount is not known yet" \
    root YES=1 "$install" gone
expect_after="$output"
count=$((count + 1))
if [[ "$expect_after" == *"before the package lists"*"Need to get 12.3 MB"*Installing* ]]; then echo \
    "ok $count - and says it once they are there"; else
    failed=1
    echo "not ok $count - and says it once they are there"
    sed 's/^/# /' <<<"$expect_after"
fi
asked >/dev/null

# Somebody else's link under a name that could be guessed, in the folder for temporary files.
mkdir "$folder/tmp"
echo precious >"$folder/victim"
ln -s ../victim "$folder/tmp/cournand-packages-0.lock"
ln -s ../victim "$folder/tmp/cournand-packages-$(id -u).lock" 2>/dev/null
expect 0 "" "it runs with links planted in TMPDIR" root TMPDIR="$folder/tmp" YES=1 "$install" gone
count=$((count + 1))
if [ "$(cat "$folder/victim")" = precious ]; then echo "ok $count - a planted link empties no file"; else
    failed=1
    echo "not ok $count - a planted link empties no file"
fi
count=$((count + 1))
if [ -z "$(find "$folder/tmp" -type f)" ]; then echo "ok $count - no lock and no log stay behind"; else
    failed=1
    echo "not ok $count - no lock and no log stay behind"
fi

# The two commands of the README ask once, for all their sections; continuous integration says yes.
goal() { env -u YES -u CI -u MAKEFLAGS -u MAKELEVEL make -n -C "$PWD" PACKAGES=install "$1" 2>/dev/null |
    grep -c 'install_packages.sh'; }
for target in run test; do
    count=$((count + 1))
    questions="$(goal $target)"
    if [ "$questions" = 1 ]; then echo "ok $count - make $target asks at most once"; else
        failed=1
        echo "not ok $count - make $target asks at most once"
        echo "# install_packages.sh is called $questions times"
    fi
done
count=$((count + 1))
if grep -qx 'export YES=1' .ci/run; then echo "ok $count - .ci/run says yes"; else
    failed=1
    echo "not ok $count - .ci/run says yes"
fi
echo "1..$count"
exit $failed
