"""Runs functions that return whether their claims hold, for tests that print TAP."""

import sys


def run(tests):
    """Runs each test function and prints one TAP line with its name. If a test fails, the program ends with exit code
    1."""
    failed = 0
    print("1..%d" % len(tests))
    for count, test in enumerate(tests, 1):
        good = test()
        failed += not good
        print("%s %d - %s" % ("ok" if good else "not ok", count, test.__name__))
    sys.exit(1 if failed else 0)
