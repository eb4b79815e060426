"""Clocks."""

from __future__ import annotations

import time
from collections.abc import Callable


def clock(n_threads: int) -> Callable[[], float]:
    """The time that one thread works, whatever else the machine does; with more threads, that on the wall."""
    return time.process_time if n_threads == 1 else time.perf_counter
