"""Points and a forest: the tiles that may hold the answers of a point are queried, and their answers are merged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from .. import _core
from ..arrays import FloatArray, IntArray
from ..progress import ProgressCallback, staged
from ..query.ignore import Ignored
from ..query.proximity.backend import NearColumns, NearLists
from ..query.proximity.points import PointBatch
from ..threads import get_num_threads
from .routing import by_tile, in_tile, in_whole
from .tile_store import Tile, TileStore
from .top_tree import TopTree

#: The most points that look for their nearest tiles at a time; sorted by tile, so that few tiles are queried.
MOST_POINTS = 1 << 20

#: The points that look first for the tiles within their radius, and about how many pairs of a point and a tile there
#: are at a time; the nearest tiles of points are no more.
FIRST_POINTS, MOST_PAIRS = 1 << 16, 1 << 23

#: Each round queries this many times as many tiles as before.
MORE_TILES = 4

#: Covers what squaring rounds in the distance of a tie, as a fraction of it.
ROUNDING = np.float32(2.0**-20)


@dataclass(frozen=True, eq=False)
class ForestPoints:
    """Answers points about the primitives of all tiles; see `PointBackend`."""

    store: TileStore
    top: TopTree

    def nearest(self, points: PointBatch, k: int, progress: ProgressCallback | None) -> NearColumns:
        """See `PointBackend`; the next tiles are queried while they may hold what is nearer than the k-th so far."""
        n = len(points)
        best = _Best.of(n, k)
        order = np.arange(n) if n <= MOST_POINTS else self._sorted(points)
        for begin in range(0, n, MOST_POINTS):
            end = min(begin + MOST_POINTS, n)
            self._find_nearest(points, order[begin:end], best, staged(progress, begin / n, end / n))
        return best.columns

    def within(self, points: PointBatch, progress: ProgressCallback | None) -> NearLists:
        """See `PointBackend`."""
        parts = []
        for tile, rows, share in self._within(points, progress):
            offsets, (distance, prim, u) = tile.tree._point_backend().within(_in_tile(points, rows, tile), share)
            parts.append((rows, offsets, in_whole(tile, prim), distance, u))
        offsets, prim, distance, u = _core.merge_lists(len(points), parts, True, get_num_threads(), None)
        return offsets, (distance, prim, u)

    def count_within(self, points: PointBatch, progress: ProgressCallback | None) -> IntArray:
        """See `PointBackend`."""
        counts = np.zeros(len(points), np.int64)
        for tile, rows, share in self._within(points, progress):
            counts[rows] += tile.tree._point_backend().count_within(_in_tile(points, rows, tile), share)
        return counts

    def _sorted(self, points: PointBatch) -> IntArray:
        """Return the points in the order of the tiles that are nearest to them."""
        first = [
            self.top.nearest_tiles(_bare(points, np.arange(begin, min(begin + MOST_POINTS, len(points)))), 1)[1]
            for begin in range(0, len(points), MOST_POINTS)
        ]
        return np.argsort(np.concatenate(first)[:, 0], kind="stable")

    def _find_nearest(
        self, points: PointBatch, rows: IntArray, best: _Best, progress: ProgressCallback | None, n_asked: int = 0
    ) -> None:
        """Query the 1, 4, 16, … nearest tiles of some points, until the next one is too far away."""
        n_tiles, done = len(self.store), 0.0
        while len(rows) and n_asked < n_tiles:
            n_next = min(max(1, MORE_TILES * n_asked), n_tiles)
            most = max(1, MOST_PAIRS // n_next)
            if len(rows) > most:
                for begin in range(0, len(rows), most):
                    end = min(begin + most, len(rows))
                    share = staged(progress, *(done + (1 - done) * at / len(rows) for at in (begin, end)))
                    self._find_nearest(points, rows[begin:end], best, share, n_asked)
                return
            distance, tile = self.top.nearest_tiles(_bare(points, rows), n_next)
            distance, tile = distance[:, n_asked:], tile[:, n_asked:]
            # Each round is half of what is left.
            share = staged(progress, done, (1 + done) / 2)
            for found, entries, of_tile in by_tile(self.store, tile.reshape(-1), share):
                row, bound = rows[entries // tile.shape[1]], distance.reshape(-1)[entries]
                limit = best.limit(points, row)
                near = bound <= limit
                if near.any():
                    self._query_tile(found, points, row[near], limit[near], best, of_tile)
            rows = rows[(tile[:, -1] >= 0) & (distance[:, -1] <= best.limit(points, rows))]
            n_asked, done = n_next, (1 + done) / 2

    @staticmethod
    def _query_tile(
        tile: Tile,
        points: PointBatch,
        rows: IntArray,
        limit: FloatArray,
        best: _Best,
        progress: ProgressCallback | None,
    ) -> None:
        """Put what a tile holds within limits among the best of some points."""
        some = replace(_in_tile(points, rows, tile), radius=np.maximum(limit, 0))
        k = min(best.k, len(tile.tree.geometry))
        distance, prim, u = tile.tree._point_backend().nearest(some, k, progress)
        _core.merge_nearest(best.columns, best.k, rows, (distance, in_whole(tile, prim), u))

    def _within(
        self, points: PointBatch, progress: ProgressCallback | None
    ) -> Iterator[tuple[Tile, IntArray, ProgressCallback | None]]:
        """Open the tiles that may have something within the radius of some points, with these."""
        n, begin, size = len(points), 0, FIRST_POINTS
        while begin < n:
            end = min(begin + size, n)
            some = _bare(points, np.arange(begin, end))
            offsets, tile = self.top.tiles_within(some, some.radius)
            row = np.repeat(np.arange(begin, end), np.diff(offsets))
            for found, entries, share in by_tile(self.store, tile, staged(progress, begin / n, end / n)):
                yield found, row[entries], share
            size = max(1, min(MOST_POINTS, (end - begin) * MOST_PAIRS // max(1, len(tile))))
            begin = end


@dataclass(frozen=True, eq=False)
class _Best:
    """The k best answers of each point so far."""

    k: int
    distance: FloatArray
    prim: IntArray
    u: FloatArray

    @classmethod
    def of(cls, n_points: int, k: int) -> _Best:
        """Return no answers yet. Ctrl-C stops between blocks, as the first touch of so much memory takes long."""
        n = n_points * k
        best = cls(k, np.empty(n, np.float32), np.empty(n, np.int64), np.empty(n, np.float32))
        for begin in range(0, n, MOST_PAIRS):
            block = slice(begin, begin + MOST_PAIRS)
            best.distance[block], best.prim[block], best.u[block] = np.inf, -1, 0
        return best

    @property
    def columns(self) -> NearColumns:
        return self.distance, self.prim, self.u

    def limit(self, points: PointBatch, rows: IntArray) -> FloatArray:
        """Return how far further answers of some points may be, (n,): ties with the k-th so far count."""
        last = self.distance[rows * self.k + self.k - 1]
        return np.minimum(points.radius_of(rows), np.nextafter(last + ROUNDING * np.abs(last), np.float32(np.inf)))


def _bare(points: PointBatch, rows: IntArray) -> PointBatch:
    """Return some points without what they leave out."""
    return replace(points, ignored=()).some(rows)


def _in_tile(points: PointBatch, rows: IntArray, tile: Tile) -> PointBatch:
    """Return some points, which leave out primitives by their numbers in a tile."""

    def local(ignored: Ignored) -> Ignored:
        return ignored if ignored.are_strands else replace(ignored, numbers=in_tile(tile, ignored.numbers))

    some = points.some(rows)
    return replace(some, ignored=tuple(map(local, some.ignored)))
