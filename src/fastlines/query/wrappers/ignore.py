"""Queries that leave out primitives: the answers are those of a tree without them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry
from ...progress import ProgressCallback
from ..at import At
from ..backend import Backend, HitColumns, HitLists
from ..hit_lists import chosen, count_by_listing, joined
from ..rays import RayBatch


@dataclass(frozen=True)
class IgnoringBackend(Backend):
    """Leaves out what rays ignore; see `Backend`."""

    all: Backend
    geometry: AnyGeometry

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`; rays whose first hit is left out ask for their next ones, more and more of them."""
        t, prim, u, distance, t_out = self.all.first_hit(rays, at, progress)
        t, prim, u, distance = t.copy(), prim.copy(), u.copy(), distance.copy()
        t_out = None if t_out is None else t_out.copy()
        left = np.flatnonzero(self._drops(rays, prim, np.arange(len(rays))))
        k = 1
        while len(left):
            k *= 4
            some = rays.some(left)
            offsets, lists = self.all.list_hits(some, at, k, False, None)
            ray = np.repeat(np.arange(len(left)), np.diff(offsets))
            kept = np.flatnonzero(~self._drops(some, lists[1], ray))
            found, first = np.unique(ray[kept], return_index=True)
            pairs: list[tuple[Any, Any]] = list(zip((t, prim, u, distance, t_out), lists, strict=True))
            for (to, column), missing in zip(pairs, (np.inf, -1, 0, np.inf, np.inf), strict=True):
                if to is not None:
                    to[left] = missing
                    to[left[found]] = column[kept[first]]
            is_full = np.diff(offsets) == k
            is_full[found] = False
            left = left[is_full]
        return t, prim, u, distance, t_out

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        return np.asarray(self.first_hit(rays, at, progress)[1] >= 0)

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return count_by_listing(rays, lambda some: self.list_hits(some, at, None, False, None), progress)

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`; what is left out counts."""
        return self.all.count_candidates(rays, progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        if k is None or not len(rays):
            return self._kept(rays, self.all.list_hits(rays, at, k, by_distance, progress))
        # Ask for more hits until k of them are left, or the ray has no more.
        left, asked, parts = np.arange(len(rays)), max(k, 1), []
        while len(left):
            some = rays.some(left)
            listed = self.all.list_hits(some, at, asked, by_distance, progress)
            offsets, columns = self._kept(some, listed)
            is_done = (np.diff(offsets) >= k) | (np.diff(listed[0]) < asked)
            of_ray = np.repeat(np.arange(len(left)), np.diff(offsets))
            is_kept = is_done[of_ray] & (np.arange(len(of_ray)) - offsets[of_ray] < k)
            parts.append((left, chosen(offsets, columns, is_kept)))
            left, asked = left[~is_done], 4 * asked
        return joined(len(rays), parts)

    def _kept(self, rays: RayBatch, lists: HitLists) -> HitLists:
        """Return the lists without what is left out."""
        offsets, columns = lists
        ray = np.repeat(np.arange(len(rays)), np.diff(offsets))
        return chosen(offsets, columns, ~self._drops(rays, columns[1], ray))

    def _drops(self, rays: RayBatch, prim: IntArray, ray: IntArray) -> npt.NDArray[np.bool_]:
        """Return whether each hit is left out."""
        dropped = np.zeros(len(prim), bool)
        for ignored in rays.ignored:
            dropped |= ignored.drops(self.geometry, prim, ray)
        return dropped
