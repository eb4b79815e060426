"""Points as tasks: sorted by their nearest tile, cut into chunks, and their answers put in their places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...progress import ProgressCallback
from ...query.proximity.backend import NearColumns, NearLists, PointBackend
from ...query.proximity.points import PointBatch
from .forest_address import ForestAddress
from .mapped_rays import HERE, joined_lists
from .mapping import Chunk, Mapping

if TYPE_CHECKING:
    from ..forest import Forest


@dataclass(frozen=True, eq=False)
class PointWork:
    """A query of a chunk of points; see `Work`."""

    forest: ForestAddress
    #: The name of a method of `PointBackend`, and its arguments between the points and the callback.
    query: str
    how: tuple[Any, ...]
    points: PointBatch

    def done(self) -> Any:
        """Answer the points with the tiles that this process sees."""
        return getattr(self.forest.opened()._point_backend(), self.query)(self.points, *self.how, None)


@dataclass(frozen=True, eq=False)
class MappedPoints:
    """Answers points by tasks; see `PointBackend`."""

    forest: Forest
    #: What answers few points, in this process.
    here: PointBackend
    mapping: Mapping

    def nearest(self, points: PointBatch, k: int, progress: ProgressCallback | None) -> NearColumns:
        """See `PointBackend`."""
        if len(points) <= HERE:
            return self.here.nearest(points, k, progress)
        n = len(points)
        distance, prim, u = np.full((n, k), np.inf, np.float32), np.full((n, k), -1), np.zeros((n, k), np.float32)
        for chunk in self._chunks("nearest", (k,), points, progress):
            for to, column in zip((distance, prim, u), chunk.answer, strict=True):
                to[chunk.rows] = column.reshape(-1, k)
        return distance.reshape(-1), prim.reshape(-1), u.reshape(-1)

    def within(self, points: PointBatch, progress: ProgressCallback | None) -> NearLists:
        """See `PointBackend`."""
        if len(points) <= HERE:
            return self.here.within(points, progress)
        chunks = list(self._chunks("within", (), points, progress))
        offsets, (distance, prim, u) = joined_lists(len(points), chunks, [np.float32, np.int64, np.float32])
        return offsets, (distance, prim, u)

    def count_within(self, points: PointBatch, progress: ProgressCallback | None) -> IntArray:
        """See `PointBackend`."""
        if len(points) <= HERE:
            return self.here.count_within(points, progress)
        counts = np.zeros(len(points), np.int64)
        for chunk in self._chunks("count_within", (), points, progress):
            counts[chunk.rows] = chunk.answer
        return counts

    def _chunks(
        self, query: str, how: tuple[Any, ...], points: PointBatch, progress: ProgressCallback | None
    ) -> Iterator[Chunk[Any]]:
        """Yield the answers of chunks of points, all but those that are near to no tile."""
        address, tile = ForestAddress.of(self.forest), self._nearest_tile(points)

        def work(rows: IntArray) -> PointWork:
            return PointWork(address, query, how, points.some(rows))

        arrays: list[npt.NDArray[Any]] = [points.points, points.radius]
        arrays += [each.numbers for each in points.ignored if each.is_per_ray]
        n_bytes = sum(array.nbytes for array in arrays)
        yield from self.mapping.rows(tile, self.forest.n_tiles, work, n_bytes, progress)

    def _nearest_tile(self, points: PointBatch) -> IntArray:
        if self.forest.n_tiles == 1:
            return np.zeros(len(points), np.int64)
        tiles: IntArray = self.forest._top.nearest_tiles(points, 1)[1][:, 0]
        return tiles
