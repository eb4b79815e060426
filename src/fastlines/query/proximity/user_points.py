"""Points and primitives of your own: the core finds boxes in the order of their distance, and `nearest` decides.

Answers are those of brute force, which asks about all pairs. Each pair is a row of an array, so its result must not
depend on the other rows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ...arrays import FLOAT32_MAX, FloatArray, IntArray
from ...geometry.any_geometry import AnyGeometry
from ...geometry.hit_places import Float64Array
from ...geometry.user_primitives import UserPrimitives
from ...progress import ProgressCallback
from ..chunks import CHUNK_PAIRS, Chunks
from ..hit_lists import offsets_of
from .backend import NearColumns, NearLists, PointBackend
from .points import PointBatch

#: The first search for a point asks for two boxes for each answer, and this many more; each further one for twice as
#: many as the last.
MORE_BOXES = 6
#: Points that are searched first, to learn how many boxes are within their radius.
FIRST_POINTS = 16
#: A bound on what rounding may change in the distance of a box, as a fraction of it and of the scene's size.
ROUNDING = 2.0**-19


@dataclass(frozen=True)
class UserPoints:
    """Answers points about primitives of your own; see `PointBackend`."""

    primitives: UserPrimitives
    #: Finds boxes; None for brute force.
    boxes: PointBackend | None

    @classmethod
    def of(cls, geometry: AnyGeometry, boxes: PointBackend | None) -> UserPoints:
        """Return the backend for a class of the user's own, which must have the method `nearest`."""
        primitives = cast(UserPrimitives, geometry)
        primitives.require_nearest()
        return cls(primitives, boxes)

    def nearest(self, points: PointBatch, k: int, progress: ProgressCallback | None) -> NearColumns:
        """See `PointBackend`."""
        n, n_prims = len(points), len(self.primitives)
        distance, prim = np.full((n, k), np.inf, np.float32), np.full((n, k), -1)
        u = np.zeros((n, k), np.float32)
        n_left, first = n, n_prims if self.boxes is None else min(n_prims, 2 * k + MORE_BOXES)
        work = [(np.arange(n), first)]
        while work:
            # Take as many points as have about CHUNK_PAIRS pairs.
            rows, n_boxes = work.pop()
            most = max(1, CHUNK_PAIRS // max(1, n_boxes))
            if len(rows) > most:
                work.append((rows[most:], n_boxes))
                rows = rows[:most]
            some = points.some(rows)
            point, ids, beyond = self._nearest_boxes(some, n_boxes)
            found = self._answers(some, point, ids)
            offsets, (distance_of, prim_of, u_of) = found
            at, of_point = _first(offsets, k)
            # A point has its answers if all boxes that are left are farther than the last of them.
            kth = np.full(len(rows), np.inf)
            is_full = np.diff(offsets) >= k
            kth[is_full] = distance_of[offsets[:-1][is_full] + k - 1]
            is_done = (beyond == np.inf) | ((beyond > 0) & (kth < beyond))
            kept = is_done[of_point]
            to = rows[of_point[kept]], at[kept] - offsets[of_point[kept]]
            distance[to], prim[to], u[to] = distance_of[at[kept]], prim_of[at[kept]], u_of[at[kept]]
            if not is_done.all():
                work.append((rows[~is_done], min(2 * n_boxes, n_prims)))
            n_left -= int(is_done.sum())
            if progress is not None:
                progress(1 - n_left / n)
        return distance.reshape(-1), prim.reshape(-1), u.reshape(-1)

    def within(self, points: PointBatch, progress: ProgressCallback | None) -> NearLists:
        """See `PointBackend`."""
        counts = [np.zeros(0, np.int64)]
        columns: list[NearColumns] = [(np.zeros(0, np.float32), np.zeros(0, np.int64), np.zeros(0, np.float32))]
        first = FIRST_POINTS if self.boxes is not None else max(1, CHUNK_PAIRS // max(1, len(self.primitives)))
        chunks = Chunks(len(points), first, progress)
        for chunk in chunks:
            some = points.some(np.arange(chunk.start, chunk.stop))
            point, ids = self._boxes_within(some)
            chunks.n_pairs = len(ids)
            offsets, found = self._answers(some, point, ids)
            counts.append(np.diff(offsets))
            columns.append(found)
        distance, prim, u = (np.concatenate(parts) for parts in zip(*columns, strict=True))
        return np.concatenate([[0], np.cumsum(np.concatenate(counts), dtype=np.int64)]), (distance, prim, u)

    def count_within(self, points: PointBatch, progress: ProgressCallback | None) -> IntArray:
        """See `PointBackend`."""
        return np.diff(self.within(points, progress)[0])

    def _nearest_boxes(self, points: PointBatch, n_boxes: int) -> tuple[IntArray, IntArray, Float64Array]:
        """Return pairs of a point and a primitive with a near box, and how far all other boxes of a point are."""
        if self.boxes is None or not len(self.primitives):
            return *self._all_pairs(points), np.full(len(points), np.inf)
        found = self.boxes.nearest(replace(points, radius=self._box_radius(points)), n_boxes, None)
        distance, row = (column.reshape(-1, n_boxes) for column in found[:2])
        last = distance[:, -1].astype(np.float64)
        beyond = np.asarray(
            last * (1 - ROUNDING) - ROUNDING * self._size if n_boxes < len(self.primitives) else last + np.inf
        )
        point, _ = np.nonzero(row >= 0)
        return point, self.primitives.owner[row[row >= 0]], beyond

    def _boxes_within(self, points: PointBatch) -> tuple[IntArray, IntArray]:
        """Return pairs of a point and a primitive whose box is within the radius."""
        if self.boxes is None or not len(self.primitives):
            return self._all_pairs(points)
        offsets, (_, row, _) = self.boxes.within(replace(points, radius=self._box_radius(points)), None)
        return np.repeat(np.arange(len(points)), np.diff(offsets)), self.primitives.owner[row]

    def _all_pairs(self, points: PointBatch) -> tuple[IntArray, IntArray]:
        n, n_prims = len(points), len(self.primitives)
        return np.repeat(np.arange(n), n_prims), np.tile(np.arange(n_prims), n)

    def _box_radius(self, points: PointBatch) -> FloatArray:
        """Return radii that no box within reach misses by rounding."""
        radius = points.radius.astype(np.float64)
        with np.errstate(over="ignore"):
            grown = (radius + ROUNDING * (radius + self._size)).astype(np.float32)
        return np.where(points.radius < np.inf, np.minimum(grown, np.float32(FLOAT32_MAX)), points.radius)

    @property
    def _size(self) -> float:
        bounds = self.primitives.bounds.astype(np.float64)
        return float(np.ptp(bounds, axis=0).max() + np.abs(bounds).max())

    def _answers(self, points: PointBatch, point: IntArray, ids: IntArray) -> NearLists:
        """Ask about pairs, and list what is within the radius of each point."""
        kept = np.ones(len(ids), bool)
        for ignored in points.ignored:
            kept &= ~ignored.drops(self.primitives, ids, point)
        point, ids = point[kept], ids[kept]
        parts = [slice(begin, begin + CHUNK_PAIRS) for begin in range(0, max(1, len(ids)), CHUNK_PAIRS)]
        asked = [self.primitives.nearest(ids[part], points.points[point[part]]) for part in parts]
        distance, u = (np.concatenate([getattr(found, name) for found in asked]) for name in ("distance", "u"))
        kept = np.flatnonzero((distance <= points.radius_of(point)) & (distance < np.inf))
        order = kept[np.lexsort((ids[kept], distance[kept], point[kept]))]
        return offsets_of(point[order], len(points)), (distance[order], ids[order], u[order])


def _first(offsets: IntArray, k: int) -> tuple[IntArray, IntArray]:
    """Return the first k entries of each list, and the list of each."""
    of_list = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    kept = np.flatnonzero(np.arange(len(of_list)) - offsets[of_list] < k)
    return kept, of_list[kept]
