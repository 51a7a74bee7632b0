#!/usr/bin/env bash
# Installs the Debian packages of the named sections of tools/packages.txt that are missing.
# usage: install_packages.sh SECTION...
# On Debian with root or sudo it prints the packages and their size, asks on the terminal, and installs them. YES=1,
# or CI=true as build machines set it, answers the question without a person. Without a terminal and without either
# variable it installs nothing and prints the command to type. On other systems it prints the list. If a package is
# not installed, the exit code is 1.
set -euo pipefail
here="$(cd "$(dirname "$0")/.." && pwd)"
list="$here/packages.txt"
install_options=(--no-install-recommends -o DPkg::Lock::Timeout=600)

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

# Only one installer may run at a time, because `make -j` may start this script twice. The lock is on the list itself,
# opened for reading. A separate lock file in a folder that others can write to could be their link to any file of
# ours.
exec 9<"$list"
if command -v flock >/dev/null; then flock 9; fi

missing=()
for package in $(printf '%s\n' "${wanted[@]}" | sort -u); do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

if [ "$(id -u)" = 0 ]; then sudo=(); elif command -v sudo >/dev/null; then sudo=(sudo); else
    echo "Missing packages: ${missing[*]}" >&2
    echo "Neither root nor sudo: ask your administrator for the packages above, then try again." >&2
    exit 1
fi

# Prints what apt would do, in apt's words: "Need to get 12.3 MB of archives." and "After this operation, 45.6 MB of
# additional disk space will be used." --print-uris changes nothing (--assume-no would install packages that need no
# question) and needs no rights. The result is empty if the package lists are missing or too old.
sizes() {
    LC_ALL=C apt-get install -o Debug::NoLocking=1 --print-uris "${install_options[@]}" "${missing[@]}" 2>/dev/null |
        grep -E '^(Need to get |After this operation, |[0-9]+ upgraded, )' || true
}

# Returns the answer: 0 yes, 1 no, 2 no terminal to ask on.
is_agreed() {
    local answer
    case "${YES:-}" in 1 | y | yes) return 0 ;; esac
    case "${CI:-}" in true | True | 1) return 0 ;; esac
    # If make runs jobs in parallel, only one of them has the terminal as its input.
    [ -t 2 ] && { : <>/dev/tty; } 2>/dev/null || return 2
    exec 8<>/dev/tty
    printf 'Install them with %sapt-get? [Y/n] ' "${sudo[*]:+sudo }" >&8
    read -r answer <&8 || return 1
    case "$answer" in "" | y | Y | yes | Yes | YES) return 0 ;; *) return 1 ;; esac
}

refuse() { # refuse WHY
    local goals="${MAKE_GOALS:-}"
    {
        echo "$1 Either of these installs them:"
        echo "  YES=1 make${goals:+ $goals}"
        as="${sudo[*]:+sudo }"
        echo "  ${as}apt-get update && ${as}apt-get install --no-install-recommends ${missing[*]}"
        echo "PACKAGES=skip goes on without them."
    } >&2
    exit 1
}

log="$(mktemp)"
give_up() {
    tail -n 20 "$log" >&2
    echo "Installing packages failed; the full log is $log" >&2
    exit 1
}

echo "${#missing[@]} packages are missing: ${missing[*]}"
amount="$(sizes)"
if [ -n "$amount" ]; then sed 's/^/  /' <<<"$amount"; else
    echo "  How much that is, is not known here before the package lists are fetched (apt-get update)."
fi
agreed=0
is_agreed || agreed=$?
[ "$agreed" = 1 ] && { rm -f "$log"; refuse "Nothing was installed."; }
[ "$agreed" = 2 ] && { rm -f "$log"; refuse "Nothing was installed: there is no terminal to ask on."; }

"${sudo[@]}" apt-get update -qq >"$log" 2>&1 || give_up
[ -n "$amount" ] || sizes | sed 's/^/  /'
echo "Installing"
"${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "${install_options[@]}" "${missing[@]}" \
    >>"$log" 2>&1 ||
    give_up
rm -f "$log"
