#!/bin/sh
# Level L4: the whole app and its wire on a big-endian machine (s390x), on RISC-V, on a 32-bit PC and here, the former
# two by user-mode emulation. One session must give the same hashes. Run it from the root of the tree. Prints TAP.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
sources="hil_tests/l4/app_session.c $(ls firmware/tests/reference/*.c firmware/core/*.c firmware/core/*/*.c \
    firmware/app/*.c firmware/app/haptics/*.c firmware/app/safety/*.c firmware/port/sim/*.c \
    shared/wire/*.c shared/scene/*.c)"
count=0
status=0

# one MACHINE COMPILER [EMULATOR]
one() {
    count=$((count + 1))
    # shellcheck disable=SC2086 # words on purpose
    if $2 -std=c11 -O1 -I. -w -static $sources -o "$folder/$1" -lm && timeout 300 $3 "$folder/$1" >"$folder/$1.txt" &&
        cmp -s "$folder/here.txt" "$folder/$1.txt"; then
        echo "ok $count - the_app_and_its_wire_on_$1"
    else
        status=1
        echo "not ok $count - the_app_and_its_wire_on_$1"
        diff "$folder/here.txt" "$folder/$1.txt" | head -5 | sed 's/^/# /'
    fi
}

one here gcc
one s390x s390x-linux-gnu-gcc qemu-s390x
one riscv64 riscv64-linux-gnu-gcc qemu-riscv64
one i686 i686-linux-gnu-gcc
sed -n 's/^schema/#- schema/p' "$folder/here.txt"
echo "1..$count"
exit $status
