"""Checks that the tests of the environments share."""


def refuses(call, kind=ValueError):
    """Returns True if the call raises this exception with a text."""
    try:
        call()
    except kind as error:
        return len(str(error)) > 10
    return False
