#!/usr/bin/env bash
# tools/check/install_packages.sh says what is wrong and installs nothing it was not asked for. Shown with a copy in a
# temporary folder whose list names packages that are installed or do not exist. Prints TAP.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder/tools/check" "$folder/bin"
cp tools/check/install_packages.sh "$folder/tools/check/"
printf '# list\n[here]\nbash\nmake\n\n[gone]\nno-such-package-seldinger\n' >"$folder/tools/packages.txt"
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
expect 1 "no-such-package-seldinger" "the list names every package" env PATH="$folder/bin" "$install" gone
rm "$folder/bin/id"
printf '#!/bin/bash\nexit 1\n' >"$folder/bin/dpkg-query"
printf '#!/bin/bash\necho 1000\n' >"$folder/bin/id"
chmod +x "$folder/bin/dpkg-query" "$folder/bin/id"
expect 1 "Neither root nor sudo" "without root and sudo it says what to do" env PATH="$folder/bin" "$install" gone
echo "1..$count"
exit $failed
