"""Queries on curves: the core answers for their pieces, and here a hit gets the curve and its parameter.

A ray may meet several pieces of a curve where it crosses the curve once; `Pieces.crossings` joins them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...progress import ProgressCallback
from ..at import At
from ..backend import Backend, CompiledBackend, HitColumns, HitLists
from ..hit_lists import count_by_listing
from ..rays import RayBatch
from .pieces import Pieces

#: A bound on what rounding may change in t, as a fraction of the length from the origin of a ray to its end.
ROUNDING = 2.0**-16


@dataclass(frozen=True)
class CurveBackend(Backend):
    """Answers rays about curves, alone or with other geometry; see `Backend`."""

    pieces: Pieces

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        core = self.pieces.backend
        if at == "surface" and not rays.needs_extent:
            return self.pieces.named(core.first_hit(rays, at, progress))
        if at != "closest" and isinstance(core, CompiledBackend) and core.joins_pieces:
            return self.pieces.named(core.first_crossing(rays, self.pieces.geometry.owner, at, progress))
        if at == "entry":
            return self._first_entry(rays, progress)
        found = self.pieces.backend.first_hit(rays, at, progress)
        hit = np.flatnonzero(found[1] >= 0)
        t, piece = found[0][hit], found[1][hit]
        some = rays if len(hit) == len(rays) else rays.some(hit)
        best = self.pieces.crossings(some, (np.arange(len(hit) + 1), piece), False, at, 1)[1]
        _set(found, hit, best)
        # At the surface, the first piece begins the first crossing. The closest approach of its crossing may be later,
        # and that of another crossing before: look through all that have a piece up to there.
        left = hit[:0] if at == "surface" else hit[best[0] > t]
        if len(left):
            near = self._ending(rays.some(left), found[0][left])
            offsets, (_, listed, *_) = self.pieces.backend.list_hits(near, "closest", None, False, None)
            _set(found, left, self.pieces.crossings(rays.some(left), (offsets, listed), False, at, 1)[1])
        return self.pieces.named(found)

    def _first_entry(self, rays: RayBatch, progress: ProgressCallback | None) -> HitColumns:
        """Find the first crossing of each ray that it enters.

        A ray that starts inside a curve may enter other pieces of it first, which begin no crossing. So it lists more
        and more of the pieces that it enters, until one of them begins the first crossing of its curve.
        """
        found = self.pieces.backend.first_hit(rays, "entry", progress)
        left = np.flatnonzero(found[1] >= 0)
        k, offsets = 1, np.arange(len(left) + 1)
        t, piece = found[0][left], found[1][left]
        while len(left):
            best = self.pieces.crossings(rays.some(left), (offsets, piece), False, "entry", 1)
            _set_lists(found, left, best)
            # A crossing that begins up to the last piece of a full list is the first one.
            is_done = np.diff(offsets) < k
            ends = offsets[1:][has := np.diff(best[0]) == 1] - 1
            is_done[has] |= (best[1][0] < t[ends]) | ((best[1][0] == t[ends]) & (best[1][1] <= piece[ends]))
            left, k = left[~is_done], 4 * k
            if len(left):
                offsets, (t, piece, *_) = self.pieces.backend.list_hits(rays.some(left), "entry", k, False, None)
        return self.pieces.named(found)

    def _ending(self, rays: RayBatch, t: FloatArray) -> RayBatch:
        """Return rays that end at t, or later by more than rounding can change."""
        low, high = np.asarray(self.pieces.geometry.bounds, np.float64)
        lengths = np.linalg.norm(rays.directions.astype(np.float64), axis=1)
        around = np.linalg.norm(rays.origins - (low + high) / 2, axis=1) + np.linalg.norm(high - low)
        end = t + ROUNDING * (np.abs(t) + around / lengths)
        t_max = np.minimum(end, rays.scalar(rays.t_max, np.arange(len(rays))))
        return replace(rays, t_max=t_max.astype(np.float32))

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        if at == "entry":
            return np.asarray(self.first_hit(rays, at, progress)[1] >= 0)
        return self.pieces.backend.any_hit(rays, at, progress)

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return count_by_listing(rays, lambda some: self.list_hits(some, at, None, False, None), progress)

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`; these are the pieces that each ray hits."""
        return self.pieces.backend.count_candidates(rays, progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        offsets, (_, listed, *_) = self.pieces.backend.list_hits(rays, "closest", None, False, progress)
        offsets, columns = self.pieces.crossings(rays, (offsets, listed), True, at, k, by_distance, progress)
        return offsets, self.pieces.named(columns)


def _set(columns: HitColumns, rows: IntArray, hits: HitColumns) -> None:
    """Replace the hits in these rows."""
    pairs: list[tuple[Any, Any]] = list(zip(columns, hits, strict=True))
    for to, column in pairs:
        if to is not None:
            to[rows] = column


def _set_lists(columns: HitColumns, rows: IntArray, lists: HitLists) -> None:
    """Replace the hits in these rows by lists of one hit each, or of none for a miss."""
    offsets, hits = lists
    misses: Any = np.inf, -1, 0, np.inf, np.inf
    _set(columns, rows, misses)
    _set(columns, rows[np.diff(offsets) == 1], hits)
