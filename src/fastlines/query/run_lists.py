"""Lists of hits in parts that fit into given memory: runs of consecutive rays, whose hits are counted ahead."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..arrays import IntArray
from ..progress import ProgressCallback
from .at import At
from .backend import Backend, HitLists
from .rays import RayBatch

#: The bytes that a ray takes in a part: its offset.
BYTES_A_RAY = 8

#: The fewest rays whose hits are counted at a time.
COUNTED_RAYS = 1 << 16

#: The share of the work that counting is.
COUNTING = 1 / 3


def list_runs(
    backend: Backend,
    rays: RayBatch,
    at: At,
    bytes_a_hit: int,
    max_bytes: int,
    progress: ProgressCallback | None,
    *,
    least_rays: int = 0,
) -> Iterator[tuple[int, RayBatch, HitLists]]:
    """Yield runs of rays and all their hits: the first ray of the run, the run, and its lists.

    Parameters
    ----------
    least_rays : int
        How many rays a run has at least, 0 or 1, whatever they take.

    Raises
    ------
    InputError
        If the arrays of the rays have changed between two parts.
    MemoryError
        If the hits of a single ray take more than `max_bytes`, and a run may have no ray.
    """
    done = 0.0

    def watched(n_rays: int, share: float) -> ProgressCallback | None:
        """Return the callback of the next step, which does a share of the work of some rays."""
        nonlocal done
        before, step = done, share * n_rays / len(rays)
        done += step
        return None if progress is None else lambda of_step: progress(before + of_step * step)

    def count_bytes(begin: int, end: int) -> IntArray:
        some = rays.unchanged().part(begin, end)
        return bytes_a_hit * backend.count_candidates(some, watched(end - begin, COUNTING)) + BYTES_A_RAY

    for begin, end in _runs(len(rays), max_bytes, least_rays, count_bytes):
        part = rays.unchanged().part(begin, end)
        yield begin, part, backend.list_hits(part, at, None, False, watched(end - begin, 1 - COUNTING))


def _runs(
    n_rays: int, max_bytes: int, least_rays: int, count_bytes: Callable[[int, int], IntArray]
) -> Iterator[tuple[int, int]]:
    """Yield runs of rays from begin to end that take at most `max_bytes` each, as many rays as fit."""
    begin, before = 0, 0
    until = np.zeros(0, np.int64)  # the bytes up to and with each of the rays that are counted, from `begin` on
    while begin < n_rays:
        while (known := begin + len(until)) < n_rays and (not len(until) or until[-1] <= before + max_bytes):
            more = count_bytes(known, min(known + max(COUNTED_RAYS, len(until)), n_rays))
            until = np.concatenate([until, (until[-1] if len(until) else before) + np.cumsum(more)])
        n_fitting = max(least_rays, int(np.searchsorted(until, before + max_bytes, side="right")))
        if n_fitting == 0:
            raise MemoryError(
                f"the hits of ray {begin} alone take {int(until[0]) - before:,} bytes, and max_bytes={max_bytes:,}; "
                "raise max_bytes, use a smaller radius, or next_hits for the nearest"
            )
        yield begin, begin + n_fitting
        begin, before, until = begin + n_fitting, int(until[n_fitting - 1]), until[n_fitting:]
