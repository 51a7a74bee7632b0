#!/bin/sh
# test_matrix.py with every broken variant, for `make test-lab`. Prints TAP.
exec "$(dirname "$0")/test_matrix.py" all
