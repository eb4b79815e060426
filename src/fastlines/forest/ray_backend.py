"""Rays and a forest: each ray goes to the tiles on its way, and what they find becomes one answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..arrays import FloatArray, IntArray
from ..progress import ProgressCallback, staged
from ..query.at import At, has_exit
from ..query.backend import Backend, HitColumns, HitLists
from ..query.rays import NO_LIMIT, NO_SPREAD, RayBatch
from ..threads import get_num_threads
from .routing import in_whole
from .tile_store import Tile, TileStore
from .top_tree import TopTree


@dataclass(frozen=True)
class ForestRays(Backend):
    """Answers rays about all tiles of a forest; see `Backend`. Rays leave nothing out, and see all parts."""

    store: TileStore
    top: TopTree
    kernel: str

    def first_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> HitColumns:
        """See `Backend`."""
        if len(self.top) == 1:
            opened = self.store.open(0)
            return _in_whole(opened, self._backend(opened, rays).first_hit(rays, at, progress))
        found: list[HitColumns] = []
        sizes = RayBlocks(len(self.top))
        for block, watched in _blocks(rays, progress, sizes):
            routes = self._routes(block, watched, sizes)
            walk = _core.FirstHitWalk(block.arrays(), routes, has_exit(at), get_num_threads())
            for opened, part, seen in self._walk(walk, block, watched):
                walk.give(self._backend(opened, rays).first_hit(part, at, seen), opened.ids)
            found.append(walk.hits())
        return _joined_columns(found)

    def any_hit(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> npt.NDArray[np.bool_]:
        """See `Backend`."""
        if len(self.top) == 1:
            return self._backend(self.store.open(0), rays).any_hit(rays, at, progress)
        found = []
        sizes = RayBlocks(len(self.top))
        for block, watched in _blocks(rays, progress, sizes):
            walk = _core.AnyHitWalk(block.arrays(), self._routes(block, watched, sizes), get_num_threads())
            for opened, part, seen in self._walk(walk, block, watched):
                walk.give(self._backend(opened, rays).any_hit(part, at, seen))
            found.append(walk.found())
        joined: npt.NDArray[np.bool_] = _joined(found)
        return joined

    def count_hits(self, rays: RayBatch, at: At, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`."""
        if len(self.top) == 1:
            return self._backend(self.store.open(0), rays).count_hits(rays, at, progress)
        counts = np.zeros(len(rays), np.int64)
        begin = 0
        sizes = RayBlocks(len(self.top))
        for block, watched in _blocks(rays, progress, sizes):
            visit = _core.Visit(block.arrays(), self._routes(block, watched, sizes), get_num_threads())
            of_block = counts[begin : begin + len(block)]
            for tile, opened, part, seen in self._visit(visit, block, watched):
                visit.add_counts(tile, self._backend(opened, rays).count_hits(part, at, seen), of_block)
            begin += len(block)
        return counts

    def count_candidates(self, rays: RayBatch, progress: ProgressCallback | None) -> IntArray:
        """See `Backend`; these are the hits."""
        return self.count_hits(rays, "closest", progress)

    def list_hits(
        self, rays: RayBatch, at: At, k: int | None, by_distance: bool, progress: ProgressCallback | None
    ) -> HitLists:
        """See `Backend`."""
        if len(self.top) == 1:
            opened = self.store.open(0)
            offsets, columns = self._backend(opened, rays).list_hits(rays, at, k, by_distance, progress)
            return offsets, _in_whole(opened, columns)
        if k is not None and not by_distance and k <= RayBlocks.MAX_KEPT:
            return self._next_hits(rays, at, k, progress)
        found: list[HitLists] = []
        sizes = RayBlocks(len(self.top), first=RayBlocks.FIRST_RAYS)
        for block, watched in _blocks(rays, progress, sizes):
            visit = _core.Visit(block.arrays(), self._routes(block, watched, sizes), get_num_threads())
            for tile, opened, part, seen in self._visit(visit, block, watched):
                offsets, columns = self._backend(opened, rays).list_hits(part, at, k, by_distance, seen)
                visit.add_lists(tile, (offsets, _in_whole(opened, columns)))
            found.append(visit.merge(has_exit(at), k, by_distance, watched.merging()))
            sizes.fit_hits(len(block), int(found[-1][0][-1]))
        return _joined_lists(found)

    def _next_hits(self, rays: RayBatch, at: At, k: int, progress: ProgressCallback | None) -> HitLists:
        """List the first k hits of each ray, from tile to tile with falling limits."""
        found: list[HitLists] = []
        sizes = RayBlocks(len(self.top), most=RayBlocks.HITS // max(k, 16))
        for block, watched in _blocks(rays, progress, sizes):
            routes = self._routes(block, watched, sizes)
            walk = _core.NextHitWalk(block.arrays(), routes, k, has_exit(at), get_num_threads())
            for opened, part, seen in self._walk(walk, block, watched):
                walk.give(self._backend(opened, rays).list_hits(part, at, k, False, seen), opened.ids)
            found.append(walk.lists())
        return _joined_lists(found)

    def _backend(self, opened: Tile, rays: RayBatch) -> Backend:
        """Return what answers some of these rays in a tile. All rays of a batch have the same kind of kernel.

        It ignores no primitives, because `Ignored` has the numbers of the whole.
        """
        return opened.tree._backend(self.kernel, replace(rays, ignored=()))

    def _routes(self, block: RayBatch, watched: BlockProgress, sizes: RayBlocks) -> _core.RayRoutes:
        routes = self.top.routes(block, watched.routing())
        sizes.fit_steps(len(block), routes.n_steps)
        return routes

    def _walk(
        self, walk: _core.FirstHitWalk | _core.AnyHitWalk | _core.NextHitWalk, block: RayBatch, watched: BlockProgress
    ) -> Iterator[tuple[Tile, RayBatch, ProgressCallback | None]]:
        """Yield a tile and the rays that wait for it, until none waits; the caller gives their answers to `walk`."""
        while (tile := walk.next_tile(self.store.is_open)) >= 0:
            opened = self.store.open(tile)
            n_before = walk.n_waiting()
            part = _part(block, *walk.take(tile))
            yield opened, part, watched.querying(1 - n_before / len(block), len(part) / len(block) / 2)

    def _visit(
        self, visit: _core.Visit, block: RayBatch, watched: BlockProgress
    ) -> Iterator[tuple[int, Tile, RayBatch, ProgressCallback | None]]:
        """Yield each tile and the rays on whose routes it is, those that are open first."""
        n_rays = {tile: n for tile in range(len(self.top)) if (n := visit.n_rays_of(tile))}
        n_all, n_done = sum(n_rays.values()), 0
        for tile in sorted(n_rays, key=lambda tile: not self.store.is_open[tile]):
            opened = self.store.open(tile)
            part = _part(block, *visit.take(tile))
            yield tile, opened, part, watched.querying(n_done / n_all, len(part) / n_all)
            n_done += len(part)


class RayBlocks:
    """How many rays go into the next block, which bounds the memory beside the answer."""

    #: The most rays of a block; each takes about 100 bytes.
    MAX_RAYS = 1 << 20
    #: The rays of the first block of lists of hits, and the hits that later ones aim at.
    FIRST_RAYS, HITS = 1 << 18, 1 << 24
    #: The steps from tile to tile of all rays of a block, which may be as many as tiles; each takes up to 16 bytes.
    STEPS = 1 << 26
    #: The most hits that are kept of a ray while it goes from tile to tile. For more, it visits all tiles.
    MAX_KEPT = 64

    def __init__(self, n_tiles: int, *, most: int | None = None, first: int | None = None) -> None:
        self._most = self.MAX_RAYS if most is None else min(most, self.MAX_RAYS)
        self.n_rays = max(1, min(self._most, first or self._most, self.STEPS // max(1, n_tiles)))

    def fit_steps(self, n_rays: int, n_steps: int) -> None:
        """Fit the next block to the steps of this one."""
        self.n_rays = self._fitting(n_rays, n_steps, self.STEPS)

    def fit_hits(self, n_rays: int, n_hits: int) -> None:
        """Make the next block smaller if this one has so many hits."""
        self.n_rays = min(self.n_rays, self._fitting(n_rays, n_hits, self.HITS))

    def _fitting(self, n_rays: int, n_found: int, aim: int) -> int:
        return max(1, min(self._most, 4 * n_rays, n_rays * aim // max(1, n_found)))


@dataclass
class BlockProgress:
    """The progress of a block, which takes this share of the whole. A tenth of it is routing, another one merging."""

    callback: ProgressCallback | None
    begin: float
    share: float

    def routing(self) -> ProgressCallback | None:
        """Return what the search for routes reports to."""
        return self._part(0.0, 0.1)

    def querying(self, begin: float, share: float) -> ProgressCallback | None:
        """Return what a query of a tile reports to."""
        return self._part(0.1 + 0.8 * begin, 0.8 * share)

    def merging(self) -> ProgressCallback | None:
        """Return what the merge of lists reports to."""
        return self._part(0.9, 0.1)

    def _part(self, begin: float, share: float) -> ProgressCallback | None:
        return staged(self.callback, self.begin + self.share * begin, self.begin + self.share * (begin + share))


def _blocks(
    rays: RayBatch, progress: ProgressCallback | None, sizes: RayBlocks
) -> Iterator[tuple[RayBatch, BlockProgress]]:
    """Yield rays in blocks, at least one."""
    begin = 0
    while True:
        end = min(len(rays), begin + sizes.n_rays)
        share = (end - begin) / max(1, len(rays))
        block = rays if end - begin == len(rays) else rays.part(begin, end)
        yield block, BlockProgress(progress, begin / max(1, len(rays)), share)
        begin = end
        if progress is not None:
            progress(begin / max(1, len(rays)))
        if begin == len(rays):
            return


def _part(
    rays: RayBatch,
    origins: FloatArray,
    directions: FloatArray,
    radius: FloatArray,
    t_min: FloatArray,
    t_max: FloatArray,
    spread: FloatArray,
    limit: FloatArray = NO_LIMIT,
) -> RayBatch:
    """Return some of these rays, as a batch of the arrays in the order of the core."""
    spread = NO_SPREAD if rays.spread is NO_SPREAD else spread
    none = np.zeros(0, np.int64)
    arrays = origins, directions, radius, t_min, t_max, spread
    return RayBatch((len(origins),), *arrays, none, limit=limit, has_spread=rays.has_spread)


def _in_whole(tile: Tile, columns: HitColumns) -> HitColumns:
    """Return hits of a tile with the numbers of the whole."""
    t, prim, u, distance, t_out = columns
    return t, in_whole(tile, prim), u, distance, t_out


def _joined(parts: Sequence[Any]) -> Any:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _joined_columns(parts: list[HitColumns]) -> HitColumns:
    t, prim, u, distance, t_out = zip(*parts, strict=True)
    joined = None if t_out[0] is None else _joined(t_out)
    return _joined(t), _joined(prim), _joined(u), _joined(distance), joined


def _joined_lists(parts: list[HitLists]) -> HitLists:
    counts = _joined([np.diff(offsets) for offsets, _ in parts])
    offsets = parts[0][0] if len(parts) == 1 else np.concatenate([np.zeros(1, np.int64), np.cumsum(counts)])
    return offsets, _joined_columns([columns for _, columns in parts])
