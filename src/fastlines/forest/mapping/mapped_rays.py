"""Rays as tasks: sorted by the first tile that they meet, cut into chunks, and their answers put in their places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray
from ...progress import ProgressCallback
from ...query.at import At, has_exit
from ...query.backend import Backend, HitColumns, HitLists
from ...query.rays import RayBatch
from .forest_address import ForestAddress
from .mapping import Chunk, Mapping

if TYPE_CHECKING:
    from ..forest import Forest

#: Up to so many rays are answered in the process of the caller, which is sooner than any other could.
HERE = 256


@dataclass(frozen=True, eq=False)
class RayWork:
    """A query of a chunk of rays; see `Work`."""

    forest: ForestAddress
    kernel: str
    #: The name of a method of `Backend`, and its arguments between the rays and the callback.
    query: str
    how: tuple[Any, ...]
    rays: RayBatch

    def done(self) -> Any:
        """Answer the rays with the tiles that this process sees."""
        backend = self.forest.opened()._backend(self.kernel, self.rays)
        return getattr(backend, self.query)(self.rays, *self.how, None)


@dataclass(frozen=True, eq=False)
class MappedRays(Backend):
    """Answers rays by tasks; see `Backend`. What rays ignore is left out by the tasks."""

    forest: Forest
    kernel: str
    mapping: Mapping

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        if len(rays) <= HERE:
            return self._here(rays).first_hit(rays, at, progress)
        n = len(rays)
        t, u, distance, t_out = (np.full(n, value, np.float32) for value in (np.inf, 0, np.inf, np.inf))
        prim = np.full(n, -1, np.int64)
        columns: list[npt.NDArray[Any]] = [t, prim, u, distance, t_out]
        for chunk in self._chunks("first_hit", (at,), rays, progress):
            for to, column in zip(columns, chunk.answer, strict=True):
                if column is not None:
                    to[chunk.rows] = column
        return t, prim, u, distance, t_out if has_exit(at) else None

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        if len(rays) <= HERE:
            return self._here(rays).any_hit(rays, at, progress)
        found = np.zeros(len(rays), np.bool_)
        for chunk in self._chunks("any_hit", (at,), rays, progress):
            found[chunk.rows] = chunk.answer
        return found

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return self._counts("count_hits", (at,), rays, progress)

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        return self._counts("count_candidates", (), rays, progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        if len(rays) <= HERE:
            return self._here(rays).list_hits(rays, at, k, by_distance, progress)
        chunks = list(self._chunks("list_hits", (at, k, by_distance), rays, progress))
        offsets, columns = joined_lists(len(rays), chunks, [np.float32, np.int64, *[np.float32] * (2 + has_exit(at))])
        t, prim, u, distance, *t_out = columns
        return offsets, (t, prim, u, distance, t_out[0] if has_exit(at) else None)

    def _counts(self, query: str, how: tuple[Any, ...], rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        if len(rays) <= HERE:
            counts: IntArray = getattr(self._here(rays), query)(rays, *how, progress)
            return counts
        counts = np.zeros(len(rays), np.int64)
        for chunk in self._chunks(query, how, rays, progress):
            counts[chunk.rows] = chunk.answer
        return counts

    def _here(self, rays: RayBatch) -> Backend:
        return self.forest._backend(self.kernel, rays)

    def _chunks(
        self, query: str, how: tuple[Any, ...], rays: RayBatch, progress: ProgressCallback | None
    ) -> Iterator[Chunk[Any]]:
        """Yield the answers of chunks of rays, all but those that meet no tile."""
        address, tile = ForestAddress.of(self.forest), self._first_tiles(rays)

        def work(rows: IntArray) -> RayWork:
            return RayWork(address, self.kernel, query, how, rays.some(rows))

        arrays: list[npt.NDArray[Any]] = [array for array in rays.arrays() if array is not None]
        arrays += [each.numbers for each in rays.ignored if each.is_per_ray]
        n_bytes = sum(array.nbytes for array in arrays)
        yield from self.mapping.rows(tile, self.forest.n_tiles, work, n_bytes, progress)

    def _first_tiles(self, rays: RayBatch) -> IntArray:
        if self.forest.n_tiles == 1:
            return np.zeros(len(rays), np.int64)
        tiles: IntArray = self.forest._top.first_tile(rays)
        return tiles


def joined_lists(n: int, chunks: list[Chunk[Any]], types: list[type[Any]]) -> tuple[IntArray, list[npt.NDArray[Any]]]:
    """Return the lists of n rows from those of chunks, which are let go one after the other."""
    offsets = np.zeros(n + 1, np.int64)
    for chunk in chunks:
        offsets[chunk.rows + 1] = np.diff(chunk.answer[0])
    np.cumsum(offsets, out=offsets)
    found: list[npt.NDArray[Any]] = [np.empty(offsets[-1], kind) for kind in types]
    while chunks:
        chunk = chunks.pop()
        begins, columns = chunk.answer
        # Shift each list of the chunk to its place.
        to = np.repeat(offsets[chunk.rows] - begins[:-1], np.diff(begins)) + np.arange(begins[-1])
        for into, column in zip(found, columns, strict=False):
            into[to] = column
    return offsets, found
