#!/bin/sh
# test_compilers.sh with every compiler and level, for `make test-lab`. Prints TAP.
exec "$(dirname "$0")/test_compilers.sh" all
