#!/bin/sh
# make install-udev writes the rule into DESTDIR with the number that firmware and host are built with. Prints TAP.
cd "$(dirname "$0")/../../.." || exit 1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
rule="$folder/etc/udev/rules.d/60-cournand.rules"
count=0
status=0

# expect NAME USB_ID VENDOR PRODUCT: both rules name that number
expect() {
    count=$((count + 1))
    if make -s install-udev DESTDIR="$folder" USB_ID="$2" >/dev/null 2>&1 &&
        sed -e ':more' -e '/\\$/N' -e 's/\\\n *//' -e 't more' "$rule" >"$folder/joined" && # as udev joins lines
        [ "$(grep -c "idVendor}==\"$3\".*idProduct}==\"$4\".*TAG+=\"uaccess\"" "$folder/joined")" = 2 ]; then
        echo "ok $count - $1"
    else
        status=1
        echo "not ok $count - $1"
        sed 's/^/# /' "$rule"
    fi
}

expect the_rule_has_the_number_for_tests 1209:0001 1209 0001
expect the_rule_has_the_number_that_was_built 1234:abcd 1234 abcd
echo "1..$count"
exit $status
