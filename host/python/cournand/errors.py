"""The exceptions of the package: one for each error status of the C library, with the library's text.

After an exception, the world is in the same state as before the call. There are two special cases, which their texts
state. If a recording cannot be written any more, the world has advanced to the end of the call. If a replay differs
from its recording, the world stands at the first tick that differs.
"""

from __future__ import annotations


class Error(Exception):
    """The base class of all exceptions of the package. The text of the exception names the problem, its place and the
    remedy."""

    status: str = ""


class BadArgumentError(Error, ValueError):
    """An argument is not a number, out of its range, or of a wrong size."""

    status = "BAD_ARGUMENT"


class BadHandleError(Error, ValueError):
    """An object of the C library has been freed, or is of another kind."""

    status = "BAD_HANDLE"


class BadStateError(Error, RuntimeError):
    """The call is not possible in the present state of the object."""

    status = "BAD_STATE"


class BusyError(Error, RuntimeError):
    """Another thread is using the same world, batch, renderer or pool."""

    status = "BUSY"


class BadFileError(Error, OSError):
    """A file cannot be read or written, or its contents are wrong."""

    status = "BAD_FILE"


class ScriptError(BadFileError):
    """A session script has a mistake, or names a tool, a vessel or a stent that its session does not have."""

    def __init__(self, text: str, file: str = "", line: int = 0, column: int = 0) -> None:
        super().__init__(text)
        self.file: str = file
        self.line: int = line
        """Number of the line, from 1; 0 for the whole file."""
        self.column: int = column
        """Number of the column, from 1; 0 for the whole line."""


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
    """The library has an internal fault; please report it with its text."""

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
    """Returns the exception for a status of the C library."""
    return _BY_STATUS[status] if 0 <= status < len(_BY_STATUS) else InternalError
