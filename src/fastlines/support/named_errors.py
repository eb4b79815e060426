"""Errors of the operating system with the file name that those of reads and maps lack."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


def named(error: OSError, path: str | os.PathLike[str]) -> OSError:
    """Return an error with its file name. One that has a name already, or no errno, is returned as it is."""
    name = os.fspath(path)
    if error.errno is None or error.filename is not None or name in str(error):
        return error
    return OSError(error.errno, error.strerror, name)


@contextmanager
def naming(path: str | os.PathLike[str]) -> Iterator[None]:
    """Add the file name to an `OSError` that is raised in the block."""
    try:
        yield
    except OSError as error:
        raise named(error, path) from None
