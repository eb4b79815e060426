"""The tiles of a forest as sets in which pairs are sought."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..query.proximity.pair_sets import PairSet
from ..query.proximity.strand_places import Int32Array
from .geometry import ForestGeometry
from .tile_store import Tile, TileStore
from .top_tree import TopTree

#: Strands that the core can tell from each other by 32 bits, of which one value stands for none.
MOST_STRANDS = 2**32 - 1


class TileSets:
    """The sets of a forest; see `PairSets`."""

    def __init__(self, store: TileStore, top: TopTree, geometry: ForestGeometry) -> None:
        self._store, self._top, self._geometry = store, top, geometry
        # They are made when a tile is first searched, and kept while it is open.
        self._places: WeakKeyDictionary[Tile, Int32Array | None] = WeakKeyDictionary()

    def __len__(self) -> int:
        return len(self._store)

    def boxes(self) -> FloatArray:
        """See `PairSets`."""
        facts = self._store.manifest
        boxes, radius = facts.boxes, facts.max_radius[:, None]
        grown = np.stack([boxes[:, 0] - radius, boxes[:, 1] + radius], axis=1)
        grown[[not tile.n_prims for tile in facts.tiles]] = np.inf
        return grown

    def near(self, low: FloatArray, high: FloatArray) -> tuple[IntArray, IntArray]:
        """See `PairSets`."""
        return self._top.tiles_in_boxes(low, high)

    def open(self, number: int, *, with_places: bool) -> PairSet:
        """See `PairSets`."""
        tile = self._store.open(number)
        places = self._places_of(tile) if with_places else None
        return PairSet(tile.tree.layout.view, tile.tree.geometry, tile.ids, places)

    def _places_of(self, tile: Tile) -> Int32Array | None:
        if tile not in self._places:
            self._places[tile] = places_of(tile, self._geometry)
        return self._places[tile]


def places_of(tile: Tile, geometry: ForestGeometry) -> Int32Array | None:
    """Return the places of the primitives of a tile along the strands of the whole; see `strand_places`."""
    if tile.places is None:
        return None
    strand = tile.tree.geometry.strands_of(np.arange(len(tile.places)))
    if (last := strand.max(initial=-1)) >= MOST_STRANDS:
        raise InputError(
            f"{tile.tree.geometry!r} has strand {last}, and neighbours are known along {MOST_STRANDS} strands; "
            "pass skip_neighbours=0"
        )
    columns = strand, tile.places, geometry.periods_of(strand)
    return np.stack([column.astype(np.int32) for column in columns], axis=1)
