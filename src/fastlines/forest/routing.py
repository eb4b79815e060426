"""Which rows of a question go to which tile, and the numbers of primitives in a tile and in the whole."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import IntArray
from ..progress import ProgressCallback, staged
from .tile_store import Tile, TileStore

#: A tile, the entries of a list that name it, and a callback for the share of the work that they are.
ByTile = tuple[Tile, IntArray, ProgressCallback | None]


def by_tile(store: TileStore, tile: IntArray, progress: ProgressCallback | None = None) -> Iterator[ByTile]:
    """Open each tile that a list names, those that are open first; -1 names none."""
    order = np.argsort(tile, kind="stable")
    order = order[np.searchsorted(tile[order], 0) :]
    named = tile[order]
    begins, ends = np.flatnonzero(np.diff(named, prepend=-1)), np.flatnonzero(np.diff(named, append=-1)) + 1
    groups = list(zip(begins.tolist(), ends.tolist(), strict=True))
    groups.sort(key=lambda group: not store.is_open[tile[order[group[0]]]])
    n_done = 0
    for begin, end in groups:
        n_next = n_done + end - begin
        found = store.open(int(tile[order[begin]]))
        yield found, order[begin:end], staged(progress, n_done / len(order), n_next / len(order))
        n_done = n_next
        if progress is not None:
            progress(n_done / len(order))


def in_whole(tile: Tile, prim: IntArray) -> IntArray:
    """Return the numbers in the whole of primitives of a tile; -1 for a miss."""
    if tile.ids is None:
        return prim
    if prim.min(initial=0) < 0:
        found, is_hit = np.full(prim.shape, -1), prim >= 0
        found[is_hit] = tile.ids[prim[is_hit]]
        return found
    return np.asarray(tile.ids[prim])


def in_tile(tile: Tile, prim: IntArray) -> IntArray:
    """Return the numbers in a tile of primitives of the whole; -1 for those that it does not hold."""
    if tile.ids is None:
        return prim
    if not len(tile.ids):
        return np.full(prim.shape, -1)
    at = np.minimum(np.searchsorted(tile.ids, prim), len(tile.ids) - 1)
    return np.where(tile.ids[at] == prim, at, -1)
