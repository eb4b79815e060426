"""What is in axis-parallel boxes, of the tiles of a forest."""

from __future__ import annotations

import numpy as np

from .. import _core
from ..progress import ProgressCallback
from ..query.proximity.box_queries import RowLists
from ..query.proximity.regions import Regions
from .routing import by_tile, in_whole
from .tile_store import TileStore
from .top_tree import TopTree


def find_in_boxes(
    store: TileStore, top: TopTree, regions: Regions, n_threads: int, progress: ProgressCallback | None
) -> RowLists:
    """List the primitives in checked boxes."""
    offsets, tile = top.tiles_in_boxes(regions.low, regions.high)
    box, parts = np.repeat(np.arange(len(regions)), np.diff(offsets)), []
    for found, entries, share in by_tile(store, tile, progress):
        boxes = box[entries]
        ends, rows = found.tree._find_in_boxes(regions.some(boxes), n_threads, share)
        parts.append((boxes, ends, in_whole(found, rows), None, None))
    merged = _core.merge_lists(len(regions), parts, False, n_threads, None)
    return merged[0], merged[1]
