#!/bin/sh
# Runs the program cournand with the image in an emulator (--device emulator): it gives the sim's hash, and names a
# remedy for what is missing. Prints TAP.
build="${BUILD:-build}"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
count=0
status=0

# expect NAME CODE TEXT COMMAND...: the command ends with CODE and prints TEXT
expect() {
    name="$1"
    code="$2"
    text="$3"
    shift 3
    count=$((count + 1))
    timeout 100 "$@" >"$folder/output" 2>&1
    got=$?
    if [ "$got" = "$code" ] && grep -q -e "$text" "$folder/output"; then
        echo "ok $count - $name"
        grep -e 'wall clock' "$folder/output" | sed 's/^/# /'
    else
        status=1
        echo "not ok $count - $name"
        echo "# ended with $got, not $code, or does not say '$text'"
        sed 's/^/# /' "$folder/output"
    fi
}

echo "advance 25 mm at 40 mm/s" >"$folder/a.session"
run="run --quiet --instrument shared/examples/instruments/j_wire.toml --session $folder/a.session"
hash=$("$build/bin/cournand" $run | sed -n 's/^final hash *//p')

expect a_session_on_the_image_has_the_hash_of_the_sim 0 "final hash *${hash:-none}" "$build/bin/cournand" $run \
    --device emulator
expect the_image_passes_its_selftest 0 ' 0 failed' "$build/bin/cournand" rig selftest --device emulator
expect an_image_that_is_missing_has_a_remedy 1 "$folder/none.elf does not exist. Remedy: make firmware" \
    env CRN_IMAGE="$folder/none.elf" "$build/bin/cournand" $run --device emulator
expect an_emulator_that_is_missing_has_a_remedy 1 'Remedy: apt-get install qemu-system-arm' \
    env PATH="$folder" "$(realpath "$build")/bin/cournand" $run --device emulator
echo "1..$count"
exit $status
