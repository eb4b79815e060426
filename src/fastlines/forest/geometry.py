"""The primitives of a forest as one geometry, which reads those of its tiles."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, FloatArray, IntArray
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry, CoreData
from ..geometry.hit_places import Float64Array, HitPlaces
from ..geometry.lines import Lines
from ..geometry.offsets import OFFSET
from ..geometry.smooth_tangents import smooth_tangents
from ..support.computed_once import computed_once
from ..support.distinct import distinct
from ..support.texts import counted
from .index import Index
from .manifest import Manifest
from .tile_store import Tile, TileStore

#: A call for one tile: its geometry, the rows that it fills, and the numbers of their primitives in the tile.
Ask = Callable[[AnyGeometry, IntArray, IntArray], Any]

#: Of how many of the first primitives strands are counted, and their turns are found, to choose a look.
COUNTED, TURNS = 1 << 20, 1 << 12


class ForestGeometry(AnyGeometry):
    """The primitives of all tiles, by their numbers in the whole; nothing of their number is in memory.

    Parameters
    ----------
    store : TileStore
    index : Index

    Attributes
    ----------
    store, index
    """

    def __init__(self, store: TileStore, index: Index, has_offset: bool = True) -> None:
        self.store, self.index, self._has_offset = store, index, has_offset

    def __reduce__(self) -> tuple[Any, ...]:
        store = self.store
        how: dict[str, Any] = {"memory": store.memory, "verify": store.verify, "has_offset": self._has_offset}
        return partial(open_geometry, **how), (os.fspath(store.folder),)

    @property
    def manifest(self) -> Manifest:
        """What is known of the forest without its tiles."""
        return self.store.manifest

    @property
    def sampled(self) -> AnyGeometry:
        """Some of the primitives, in memory; they are of the same kind, with the same attributes."""
        return self.index.sample

    # --- Tiles ---

    def locate(self, prim: IntArray) -> tuple[IntArray, IntArray]:
        """Return the tile of each of some primitives, and its number there."""
        local = np.empty(len(prim), np.int64)
        for _, rows, numbers in self._by_tile(prim):
            local[rows] = numbers
        return self.index.tile_of[prim].astype(np.int64), local

    def _by_tile(self, prim: IntArray) -> Iterator[tuple[Tile, IntArray, IntArray]]:
        """Yield each tile that some primitives are in, with the rows of these, and their numbers there."""
        tile = self.index.tile_of[prim]
        order = np.argsort(tile, kind="stable")
        begins = np.flatnonzero(np.diff(tile[order].astype(np.int64), prepend=-1))
        for rows in np.split(order, begins)[1:]:
            found = self.store.open(int(tile[rows[0]]))
            yield found, rows, number_in(found, prim[rows])

    def _filled(self, found: AnyArray, prim: IntArray, ask: Ask) -> Any:
        """Fill rows with what the geometry of each tile says of some primitives."""
        for tile, rows, numbers in self._by_tile(prim):
            found[rows] = ask(tile.tree.geometry, rows, numbers)
        return found

    def _at(self, hits: HitPlaces, ask: Callable[[AnyGeometry, HitPlaces], Float64Array]) -> Float64Array:
        """Return vectors at hits, (n, 3)."""
        found = np.full((len(hits.prim), 3), np.nan)
        self._filled(found, hits.prim, lambda of, rows, prim: ask(of, replace(hits.some(rows), prim=prim)))
        return found

    # --- What the core gets ---

    @property
    def kind(self) -> str:
        """See `AnyGeometry`."""
        return self.sampled.kind

    @property
    def core_rows(self) -> FloatArray:
        """Those of tiles alone are in memory."""
        raise InputError(f"{self!r} is not in memory; its tiles are queried one after the other")

    def build_data(self) -> CoreData:
        """See `core_rows`."""
        return self.kind, self.core_rows

    @property
    def takes_spread(self) -> bool:
        """See `AnyGeometry`."""
        return self.sampled.takes_spread

    def require_gpu(self) -> None:
        """See `AnyGeometry`."""
        raise InputError("forests are queried on the CPU; load a tile of it as a tree, and place that on a GPU")

    # --- Extent ---

    def __len__(self) -> int:
        return self.manifest.n_prims

    @property
    def bounds(self) -> FloatArray:
        """The box of all axes, (2, 3): lowest and highest corner; lowest > highest if there are none."""
        return self.manifest.bounds if len(self) else np.array([[np.inf] * 3, [-np.inf] * 3], np.float32)

    def span(self) -> tuple[FloatArray, FloatArray]:
        """Return points of the sample."""
        return self.sampled.span()

    @property
    def radius(self) -> FloatArray | None:
        """The radius of the sample; None if the primitives have none."""
        return self.sampled.radius

    @property
    def max_radius(self) -> float:
        """See `AnyGeometry`."""
        return float(max((tile.max_radius for tile in self.manifest.tiles), default=0.0))

    @property
    def radius_range(self) -> tuple[float, float] | None:
        """See `AnyGeometry`."""
        if self.radius is None or not len(self):
            return None
        return min(tile.min_radius for tile in self.manifest.tiles if tile.n_prims), self.max_radius

    @property
    def needs_radius(self) -> bool:
        """See `AnyGeometry`."""
        return self.sampled.needs_radius

    def radius_of(self, prim: IntArray) -> Float64Array:
        """See `AnyGeometry`."""
        return np.asarray(self._filled(np.zeros(len(prim)), prim, lambda of, _, numbers: of.radius_of(numbers)))

    # --- Hits ---

    @property
    def has_axes(self) -> bool:
        """See `AnyGeometry`."""
        return self.sampled.has_axes

    def points_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda of, places: of.points_at(places))

    def nearest_at(self, hits: HitPlaces, surface: bool) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda of, places: of.nearest_at(places, surface))

    def normals_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda of, places: of.normals_at(places))

    def tangents_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda of, places: of.tangents_at(places))

    @property
    def has_directions(self) -> bool:
        """See `AnyGeometry`."""
        return self.sampled.has_directions

    def lines_at(self, prim: IntArray, u: FloatArray) -> FloatArray:
        """See `AnyGeometry`."""
        found = super().lines_at(prim, u)
        return np.asarray(self._filled(found, prim, lambda of, rows, numbers: of.lines_at(numbers, u[rows])))

    def smooth_tangents_at(self, prim: IntArray, u: FloatArray, tangents: FloatArray) -> FloatArray:
        """See `AnyGeometry`; the neighbours of a segment may be in other tiles."""
        gathered = distinct(np.clip(np.concatenate([prim - 1, prim, prim + 1]), 0, len(self) - 1))
        at = np.searchsorted(gathered, prim)
        return smooth_tangents(self.ends_of(gathered), self.strands_of(gathered), at, u, tangents)

    def axis_points(self, prim: IntArray, u: AnyArray) -> Float64Array:
        """See `AnyGeometry`."""
        found = np.full((len(prim), 3), np.nan)
        return np.asarray(self._filled(found, prim, lambda of, rows, numbers: of.axis_points(numbers, u[rows])))

    def rows_of(self, prim: IntArray) -> IntArray:
        """See `AnyGeometry`."""
        skipped = self.index.skipped
        return np.asarray(prim + np.searchsorted(skipped - np.arange(len(skipped)), prim, side="right"))

    def strands_of(self, prim: IntArray) -> IntArray:
        """See `AnyGeometry`."""
        strands = self.index.strands
        return np.full(len(prim), -1) if strands is None else np.maximum(strands[prim].astype(np.int64), -1)

    @computed_once
    def end_of_strands(self) -> int:
        """See `AnyGeometry`; the mapped column of the index is read once."""
        strands = self.index.strands
        return 0 if strands is None else int(strands.max(initial=-1)) + 1

    def periods_of(self, strands: IntArray) -> IntArray:
        """Return how many primitives each of some strands has if it is closed, and 0 if it is open."""
        numbers, sizes = self.index.closed.T
        at = np.searchsorted(numbers, strands)
        found = np.zeros(len(strands), np.int64)
        known = at < len(numbers)
        known[known] = numbers[at[known]] == strands[known]
        found[known] = sizes[at[known]]
        return found

    # --- Attributes ---

    @property
    def sample_names(self) -> Mapping[str, None]:
        """See `AnyGeometry`."""
        return self.sampled.sample_names

    def sample(self, name: str, hits: HitPlaces) -> npt.NDArray[Any]:
        """See `AnyGeometry`."""
        if name not in self.sample_names:
            return super().sample(name, hits)  # says so
        none = self.sampled.sample(name, hits.some(np.zeros(0, np.int64)))
        found = np.empty((len(hits.prim), *none.shape[1:]), none.dtype)
        self._filled(found, hits.prim, lambda of, rows, prim: of.sample(name, replace(hits.some(rows), prim=prim)))
        return found

    def sample_needs_rays(self, name: str) -> bool:
        """See `AnyGeometry`."""
        return self.sampled.sample_needs_rays(name)

    def sample_shape(self, name: str) -> tuple[int, ...]:
        """See `AnyGeometry`."""
        return self.sampled.sample_shape(name)

    def arrays_of(self, name: str) -> list[tuple[AnyArray, int]]:
        """Return those of the sample."""
        return self.sampled.arrays_of(name)

    def attribute_types(self) -> dict[str, str]:
        """See `AnyGeometry`."""
        return self.sampled.attribute_types()

    def place_of(self, name: str) -> str:
        """See `AnyGeometry`."""
        return self.sampled.place_of(name)

    # --- Strands, and how lines run ---

    @property
    def n_strands(self) -> int:
        """See `AnyGeometry`."""
        return self.manifest.n_strands

    @property
    def total_length(self) -> float:
        """See `AnyGeometry`."""
        return sum(tile.total_length for tile in self.manifest.tiles)

    # --- Words ---

    @property
    def noun(self) -> str:
        """See `AnyGeometry`."""
        return self.sampled.noun

    def __repr__(self) -> str:
        has = [self.count_text(), *([counted(self.n_strands, "strands")] * (self.n_strands > 0)), *self.sample_names]
        return f"<{type(self).__name__}: {', '.join(has)}, in {counted(len(self.store), 'tiles')}>"

    @property
    def n_skipped(self) -> int:
        """See `AnyGeometry`."""
        return len(self.index.skipped)

    @property
    def up(self) -> str | None:
        """See `AnyGeometry`."""
        return self.manifest.facts.get("up")

    @property
    def unit(self) -> str | None:
        """See `AnyGeometry`."""
        return self.manifest.facts.get("unit")

    @property
    def metadata(self) -> Mapping[str, Any]:  # type: ignore[override]
        """See `AnyGeometry`."""
        found: Mapping[str, Any] = self.manifest.facts.get("metadata") or {}
        return found if self._has_offset else {name: value for name, value in found.items() if name != OFFSET}

    def without_offset(self) -> ForestGeometry:
        """See `AnyGeometry`."""
        return ForestGeometry(self.store, self.index, has_offset=False)

    def ends_of(self, prim: IntArray) -> FloatArray:
        """Return both ends of some segments, (m, 2, 3)."""
        ends = [self.axis_points(prim, np.full(len(prim), float(end))) for end in (0, 1)]
        return np.stack(ends, axis=1).astype(np.float32)

    def first_directions_of(self, prim: IntArray) -> FloatArray:
        """Return the direction at the start of some segments, of any length, (m, 3)."""
        ends = self.ends_of(prim)
        return ends[:, 1] - ends[:, 0]

    def summary(self) -> dict[str, Any]:
        """See `AnyGeometry`."""
        bounds = self.bounds if len(self) else None
        texts = self.attribute_texts()
        return {
            f"n_{self.noun}": len(self),
            "n_strands": self.n_strands,
            "bounds": None if bounds is None else (bounds + np.array(self.offset)).tolist(),
            "size": None if bounds is None else (bounds[1] - bounds[0]).tolist(),
            "total_length": self.total_length,
            "radius": None if self.radius_range is None else list(self.radius_range),
            "attributes": {name: " or ".join(texts[name]) for name in sorted(texts)},
            **({} if "offset" not in self.metadata else {"offset": list(self.offset)}),
            "up": self.up,
            "unit": self.unit,
            "n_skipped": self.n_skipped,
        }

    # --- Pictures ---

    def strand_sizes(self) -> IntArray:
        """Return those of the strands that end within the first million primitives."""
        strands = self.strands_of(np.arange(min(len(self), COUNTED)))
        if len(strands) < len(self):
            strands = strands[strands != strands[-1]]
        return np.unique(strands[strands >= 0], return_counts=True)[1]

    def turns(self) -> FloatArray | None:
        """Return those of the first few thousand segments."""
        if self.sampled.turns() is None:
            return None
        rows = np.arange(min(len(self), TURNS))
        return Lines(self.ends_of(rows), self.strands_of(rows)).turns()

    def drawn(self, rows: IntArray) -> Sequence[AnyGeometry]:
        """Return some of the sample."""
        return self.sampled.drawn(rows)

    def outlines(self) -> tuple[Float64Array, Float64Array]:
        """Return those of the sample."""
        return self.sampled.outlines()


def number_in(tile: Tile, prim: IntArray) -> IntArray:
    """Return the numbers in a tile of primitives that it holds."""
    return prim if tile.ids is None else np.searchsorted(tile.ids, prim)


def open_geometry(
    folder: str, memory: int | None = None, verify: bool | None = None, has_offset: bool = True
) -> ForestGeometry:
    """Return the geometry of the forest in a folder."""
    manifest = Manifest.read(folder)
    store = TileStore(folder, manifest, memory, verify)
    return ForestGeometry(store, Index.read(folder, manifest.n_prims, manifest.index, verify), has_offset)
