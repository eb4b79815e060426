"""Errors of the system that name their file: an open does, but a read or a map does not."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


def named(error: OSError, path: str | os.PathLike[str]) -> OSError:
    """Return an error that names a file: the same one if it names one itself, or has no number of the system."""
    name = os.fspath(path)
    if error.errno is None or error.filename is not None or name in str(error):
        return error
    return OSError(error.errno, error.strerror, name)


@contextmanager
def naming(path: str | os.PathLike[str]) -> Iterator[None]:
    """Let errors of the system that are raised within name a file."""
    try:
        yield
    except OSError as error:
        raise named(error, path) from None
