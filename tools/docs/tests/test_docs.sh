#!/bin/sh
# The tables of docs/wire.md, docs/usb.md and docs/faults.md are those of their definitions.
cd "$(dirname "$0")/../../.." || exit 1
program="${BUILD:-build}/bin/docs"
if message=$("$program" --check 2>&1); then
    echo "ok 1 - docs_tables_are_those_of_the_definition"
else
    echo "not ok 1 - docs_tables_are_those_of_the_definition"
    echo "# $message"
fi
"$program" --wrong >/dev/null 2>&1
if [ $? -eq 2 ]; then
    echo "ok 2 - docs_refuses_an_unknown_option"
else
    echo "not ok 2 - docs_refuses_an_unknown_option"
fi
echo "1..2"
