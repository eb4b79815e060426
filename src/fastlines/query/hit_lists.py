"""Lists of hits as backends return them: offsets, and columns that are sorted by ray."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..progress import ProgressCallback
from .backend import HitColumns, HitLists
from .rays import RayBatch

#: Rays whose hits are listed at a time to be counted.
CHUNK_RAYS = 1 << 16


def offsets_of(ray: IntArray, n_rays: int) -> IntArray:
    """Return where the hits of each ray begin in a list of hits of rising rays, and the end of the last."""
    return np.concatenate([[0], np.cumsum(np.bincount(ray, minlength=n_rays), dtype=np.int64)])


def first_of_each(offsets: IntArray, columns: HitColumns, k: int | None, by_distance: bool) -> HitLists:
    """Keep the first k hits of each ray, by t or by distance."""
    if k is None:
        return offsets, columns
    counts = np.diff(offsets)
    ray = np.repeat(np.arange(len(counts)), counts)
    t, prim, u, distance, t_out = columns
    order = np.lexsort((prim, t, distance, ray)) if by_distance else np.arange(len(ray))
    kept = order[np.arange(len(ray)) - offsets[ray] < k]
    to = np.concatenate([[0], np.cumsum(np.minimum(counts, k), dtype=np.int64)])
    return to, (t[kept], prim[kept], u[kept], distance[kept], None if t_out is None else t_out[kept])


def chosen(offsets: IntArray, columns: HitColumns, kept: npt.NDArray[np.bool_]) -> HitLists:
    """Keep some of the hits."""
    t, prim, u, distance, t_out = columns
    ray = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))[kept]
    some = t[kept], prim[kept], u[kept], distance[kept], None if t_out is None else t_out[kept]
    return offsets_of(ray, len(offsets) - 1), some


def joined(n_rays: int, parts: Sequence[tuple[IntArray, HitLists]]) -> HitLists:
    """Return the lists of n rays from parts: rows of rays, and their lists. Each ray has hits in one part at most."""
    ray = np.concatenate([np.repeat(rows, np.diff(offsets)) for rows, (offsets, _) in parts])
    order = np.argsort(ray, kind="stable")
    t, prim, u, distance = (np.concatenate([columns[i] for _, (_, columns) in parts])[order] for i in range(4))
    ends = [columns[4] for _, (_, columns) in parts if columns[4] is not None]
    return offsets_of(ray, n_rays), (t, prim, u, distance, np.concatenate(ends)[order] if ends else None)


def count_by_listing(
    rays: RayBatch, list_some: Callable[[RayBatch], HitLists], progress: ProgressCallback | None
) -> IntArray:
    """Count the hits of each ray by listing those of some rays at a time."""
    counts = [np.zeros(0, np.int64)]
    for begin in range(0, len(rays), CHUNK_RAYS):
        rows = np.arange(begin, min(begin + CHUNK_RAYS, len(rays)))
        counts.append(np.diff(list_some(rays.some(rows))[0]))
        if progress is not None:
            progress((rows[-1] + 1) / len(rays))
    return np.concatenate(counts)
