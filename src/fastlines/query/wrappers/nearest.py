"""The k hits that are nearest to each ray by distance, found within a radius that grows.

A ray asks for all that comes within a small radius ρ', and for more until it has enough. Whatever it has not found is
farther away than ρ'. So once the k-th distance is at most ρ', the k nearest of what is found are the k nearest of all.
What counts as a hit is decided by the ray itself, with its own radius and spread.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...geometry.hit_places import Float64Array
from ...progress import ProgressCallback
from ..at import At
from ..backend import Backend, GatherColumns, HitColumns, HitLists
from ..gather import GatherRule
from ..hit_lists import chosen, joined
from ..rays import RayBatch
from .pieces import Pieces

#: The first ρ' of a ray within the scene, as a fraction of the side of a cube that is the share of one row of the core.
FIRST = 0.25

#: By how much ρ' grows. Larger steps are fewer, but the last one finds more than is needed.
GROWTH = 1.4

#: A bound on what rounding may change, as a fraction of ρ' and of the scene's size.
ROUNDING = 2.0**-16


@dataclass(frozen=True)
class NearestBackend:
    """Answers rays by another backend, and finds the nearest hits with its pieces; see `Backend`."""

    all: Backend
    pieces: Pieces

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        return self.all.first_hit(rays, at, progress)

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        return self.all.any_hit(rays, at, progress)

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return self.all.count_hits(rays, at, progress)

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return self.all.count_candidates(rays, progress)

    def gather(self, rays: RayBatch, rule: GatherRule, progress: ProgressCallback | None) -> GatherColumns | None:
        """See `Backend`."""
        return self.all.gather(rays, rule, progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        if not by_distance or not k or not len(rays):
            return self.all.list_hits(rays, at, k, by_distance, progress)
        size, first = self._lengths()
        if first == 0:  # no rows, or all are one point
            return self.all.list_hits(rays, at, k, by_distance, progress)
        left, away, parts = np.arange(len(rays)), self._away(rays), []
        more = np.full(len(rays), first)
        most = np.where(RayBatch.scalar(rays.spread, left) > 0, np.inf, RayBatch.scalar(rays.radius, left))
        while len(left):
            # The last step is the whole query: with the whole radius, or once all of the scene is within reach.
            with np.errstate(over="ignore", invalid="ignore"):  # the origins of skipped rays are far away
                radius = (away[left] + more[left]).astype(np.float32)
            is_last = (GROWTH * radius >= most[left]) | (more[left] >= 4 * size)
            if (last := left[is_last]).size:
                parts.append((last, self.all.list_hits(rays.some(last), at, k, True, progress)))
            left, radius = left[~is_last], radius[~is_last]
            if not len(left):
                break
            some = rays.some(left)
            near = replace(some, radius=radius, spread=np.zeros_like(some.spread))
            offsets, (_, found, *_) = self.pieces.backend.list_hits(near, "closest", None, False, None)
            offsets, columns = self.pieces.crossings(some, (offsets, found), False, at, k, True)
            kth, has_k = np.zeros(len(left)), np.diff(offsets) == k
            kth[has_k] = columns[3][offsets[1:][has_k] - 1]
            is_done = has_k & (kth <= radius * (1 - ROUNDING) - ROUNDING * size)
            lists = chosen(offsets, columns, np.repeat(is_done, np.diff(offsets)))
            parts.append((left, (lists[0], self.pieces.named(lists[1]))))
            # With k hits, their distance is enough; else look farther.
            enough = (kth + 2 * ROUNDING * size) * (1 + 2 * ROUNDING) - away[left]
            more[left] = np.where(has_k, enough, GROWTH * more[left])
            left = left[~is_done]
            if progress is not None:
                progress(1 - len(left) / len(rays))
        return joined(len(rays), parts)

    def _lengths(self) -> tuple[float, float]:
        """Return the longest side of the scene, and the first ρ' of a ray within it."""
        geometry = self.pieces.geometry
        low, high = np.asarray(geometry.bounds, np.float64)
        size = max(0.0, float((high - low).max()))
        return size, FIRST * size / float(np.cbrt(max(1, len(geometry.core_rows))))

    def _away(self, rays: RayBatch) -> Float64Array:
        """Return a lower bound on the distance of each ray, between its bounds, from all axes in the scene."""
        low, high = np.asarray(self.pieces.geometry.bounds, np.float64)
        origins, directions = rays.origins.astype(np.float64), rays.directions.astype(np.float64)
        t_min, t_max = (RayBatch.scalar(t, np.arange(len(rays))).astype(np.float64) for t in (rays.t_min, rays.t_max))
        with np.errstate(invalid="ignore", over="ignore"):  # 0 times infinity
            ends = [np.where(directions == 0, origins, origins + t[:, None] * directions) for t in (t_min, t_max)]
        of_boxes = np.maximum(np.maximum(np.minimum(*ends) - high, low - np.maximum(*ends)), 0)
        # The scene lies in the ball around the middle of its box, and the ray passes that at its point nearest to it.
        middle = (low + high) / 2
        t = ((middle - origins) * directions).sum(axis=1) / (directions**2).sum(axis=1)
        nearest = origins + np.clip(t, t_min, t_max)[:, None] * directions
        of_balls = np.linalg.norm(nearest - middle, axis=1) - np.linalg.norm(high - low) / 2
        return np.asarray(np.maximum(np.linalg.norm(of_boxes, axis=1), of_balls))
