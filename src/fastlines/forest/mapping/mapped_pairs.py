"""Pairs as tasks: each searches a tile and one that is near it, or a part of these."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, cast

import numpy as np

from ...geometry.any_geometry import AnyGeometry
from ...progress import ProgressCallback
from ...query.proximity.pair_backend import MERGE_AT, PairsOfSets, PairTask, merged
from ...query.proximity.pair_query import PairColumns, PairQuery
from .forest_address import ForestAddress
from .mapping import Mapping

if TYPE_CHECKING:
    from ..forest import Forest

#: Up to so many primitives are searched in the process of the caller.
HERE = 10_000


@dataclass(frozen=True, eq=False)
class PairWork:
    """Pairs of two tiles whose first primitive is from begin up to end; see `Work`."""

    forest: ForestAddress
    #: None for pairs of one forest.
    other: ForestAddress | None
    task: PairTask
    #: Without the geometries.
    query: PairQuery
    begin: int
    end: int
    max_pairs: int

    def done(self) -> PairColumns | None:
        """Find the pairs with the tiles that this process sees; return None if there are too many."""
        other = None if self.other is None else self.other.opened()._pair_sets()
        sets = PairsOfSets(self.forest.opened()._pair_sets(), other)
        try:
            return sets.of_task(self.task, self.query, self.begin, self.end, self.max_pairs, None)
        except MemoryError:
            return None


@dataclass(frozen=True, eq=False)
class MappedPairs:
    """Finds pairs by tasks; see `PairBackend`."""

    forest: Forest
    other: Forest | None
    #: What finds pairs in this process, and the tiles that may have some.
    here: PairsOfSets
    mapping: Mapping

    def pairs(
        self, query: PairQuery, begin: int, end: int, max_pairs: int, progress: ProgressCallback | None
    ) -> PairColumns:
        """See `PairBackend`."""
        if end - begin <= HERE:
            return self.here.pairs(query, begin, end, max_pairs, progress)
        works = self._works(query, begin, end, max_pairs)
        found: list[PairColumns] = []
        n_pairs = 0
        places = [work.task.first / self.forest.n_tiles for work in works]
        for at, done in enumerate(self.mapping.run(works, places)):
            n_pairs += max_pairs + 1 if done.value is None else len(done.value[0])
            if n_pairs > max_pairs:
                raise MemoryError
            if len(done.value[0]):
                found.append(done.value)
            if progress is not None:
                progress(MERGE_AT * (at + 1) / len(works))
        return merged(found, None)

    def _works(self, query: PairQuery, begin: int, end: int, max_pairs: int) -> list[PairWork]:
        """Return the pairs of tiles that are near, each in parts if they are few."""
        first = ForestAddress.of(self.forest)
        second = None if self.other is None else ForestAddress.of(self.other)
        tasks = self.here.tasks(query)
        light = replace(query, geometry=cast(AnyGeometry, None), other=None)
        n_parts = math.ceil(self.mapping.n_chunks / max(1, len(tasks)))
        ends = np.linspace(begin, end, n_parts + 1).astype(np.int64).tolist()
        return [
            PairWork(first, second, task, light, low, high, max_pairs) for task in tasks for low, high in pairwise(ends)
        ]
