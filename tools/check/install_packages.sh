#!/usr/bin/env bash
# Installs the Debian packages of the named sections of tools/packages.txt that are missing.
# usage: install_packages.sh SECTION...
# Debian with root or sudo: installs. Elsewhere: prints the list and stops with exit code 1.
set -euo pipefail
here="$(cd "$(dirname "$0")/.." && pwd)"
list="$here/packages.txt"

wanted=()
for section in "$@"; do
    grep -qx "\[$section\]" "$list" || { echo "install_packages: no section [$section] in $list" >&2; exit 2; }
    mapfile -t lines < <(awk -v s="[$section]" '/^\[/{on=($0==s);next} on&&NF&&$1!~/^#/{print $1}' "$list")
    wanted+=("${lines[@]}")
done

if ! command -v dpkg-query >/dev/null; then
    echo "This is not a Debian system. Please install the equivalents of these packages, then run"
    echo "the same command again with PACKAGES=skip:"
    printf '  %s\n' "${wanted[@]}"
    exit 1
fi

# One installer at a time: `make -j` may start this twice.
exec 9>"${TMPDIR:-/tmp}/seldinger-packages-$(id -u).lock"
if command -v flock >/dev/null; then flock 9; fi

missing=()
for package in $(printf '%s\n' "${wanted[@]}" | sort -u); do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "Installing ${#missing[@]} missing packages: ${missing[*]}"
if [ "$(id -u)" = 0 ]; then sudo=(); elif command -v sudo >/dev/null; then sudo=(sudo); else
    echo "Neither root nor sudo: ask your administrator for the packages above, then try again." >&2
    exit 1
fi
log="$(mktemp)"
if ! { "${sudo[@]}" apt-get update -qq &&
       "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"; } >"$log" 2>&1
then
    tail -n 20 "$log" >&2
    echo "Installing packages failed; the full log is $log" >&2
    exit 1
fi
rm -f "$log"
