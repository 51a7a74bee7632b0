#!/bin/sh
# The compilers and levels that test_compilers.sh leaves to `make test-lab`. Prints TAP.
exec "$(dirname "$0")/test_compilers.sh" others
