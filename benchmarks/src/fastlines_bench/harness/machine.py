"""The machine on which figures are measured."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from fastlines import simd

from .internals import describe_machine

__all__ = ["describe", "few_processors", "load"]


def load() -> float | None:
    """Return the load average of the last minute; None if the system has none."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def describe(**more: object) -> dict[str, object]:
    """Return the processor, the system, the versions, the instruction set, the load, and all of `more`, by name."""
    return {**describe_machine(), "simd": simd(), "load": load(), **more}


@contextmanager
def few_processors(n: int) -> Iterator[None]:
    """Run this process on n processors at most, so that libraries that cannot be told start no more threads.

    Other systems than Linux have no such bound. There the processor time of one thread is that of all of them.
    """
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(before)[:n])
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)
