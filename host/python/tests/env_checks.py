"""Checks that several tests of the environments use."""


def refuses(call, kind=ValueError):
    """Returns True if the call raises this exception with a non-empty text."""
    try:
        call()
    except kind as error:
        return len(str(error)) > 10
    return False
