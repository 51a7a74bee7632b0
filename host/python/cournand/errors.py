"""The exceptions of the package: one for each status of the C library, with its text.

After an exception the world is as it was before the call. Two calls are different and say so: a recording that cannot
be written any more (the world has advanced to the end of the call), and a replay that differs (the world stands at the
first tick that differs).
"""

from __future__ import annotations


class Error(Exception):
    """What every exception of the package is. The text says what, where, and the remedy."""

    status: str = ""


class BadArgumentError(Error, ValueError):
    """An argument is not a number, out of its range, or of a wrong size."""

    status = "BAD_ARGUMENT"


class BadHandleError(Error, ValueError):
    """An object of the C library has been freed, or is of another kind."""

    status = "BAD_HANDLE"


class BadStateError(Error, RuntimeError):
    """The call is not possible now."""

    status = "BAD_STATE"


class BusyError(Error, RuntimeError):
    """Another thread is inside the same world, batch, renderer or pool."""

    status = "BUSY"


class BadFileError(Error, OSError):
    """A file cannot be read or written, or its content is wrong."""

    status = "BAD_FILE"


class RefusedError(Error, RuntimeError):
    """The simulated device or patient refuses the request."""

    status = "REFUSED"


class BadSnapshotError(Error, ValueError):
    """A snapshot is damaged, of another version, or of a world with another set-up."""

    status = "BAD_SNAPSHOT"


class DifferentError(Error, RuntimeError):
    """A replay differs from its recording."""

    status = "DIFFERENT"


class NoMemoryError(Error, MemoryError):
    """The system has no more memory or threads."""

    status = "NO_MEMORY"


class InternalError(Error, RuntimeError):
    """A fault of the library; please report it with the text."""

    status = "INTERNAL"


# In the order of cournand_status, which begins with OK.
_BY_STATUS = (
    InternalError,
    BadArgumentError,
    BadHandleError,
    BadStateError,
    BusyError,
    BadFileError,
    RefusedError,
    BadSnapshotError,
    DifferentError,
    NoMemoryError,
    InternalError,
)


def of_status(status: int) -> type[Error]:
    """Returns the exception of a status of the C library."""
    return _BY_STATUS[status] if 0 <= status < len(_BY_STATUS) else InternalError
