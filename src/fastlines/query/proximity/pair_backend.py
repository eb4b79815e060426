"""Backends for queries about pairs: the engine answers them, for two sets of primitives at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ... import _core
from ...engines import engine
from ...progress import ProgressCallback, staged
from ...threads import get_num_threads
from .pair_query import PairColumns, PairQuery, no_pairs, reach_of
from .pair_sets import PairSets

#: The fraction of a query after which the pairs of sets are merged.
MERGE_AT = 0.9


class PairBackend(Protocol):
    """Finds pairs; those of all backends are the same, bit for bit."""

    def pairs(
        self, query: PairQuery, begin: int, end: int, max_pairs: int, progress: ProgressCallback | None
    ) -> PairColumns:
        """Find the pairs whose first primitive is from begin up to end, sorted by (i, j).

        Raises
        ------
        MemoryError
            If there are more than `max_pairs`, or they do not fit into memory.
        """


@dataclass(frozen=True, eq=False)
class PairTask:
    """The sets of the first and of the second primitives of some pairs, by their numbers."""

    first: int
    second: int


@dataclass(frozen=True, eq=False)
class PairsOfSets:
    """Finds the pairs of all sets that come near each other; see `PairBackend`.

    In a self-join of several sets, the primitive with the lower number may be in either of two sets: so these are
    searched twice, from either side.
    """

    first: PairSets
    #: None for a self-join.
    second: PairSets | None

    def pairs(
        self, query: PairQuery, begin: int, end: int, max_pairs: int, progress: ProgressCallback | None
    ) -> PairColumns:
        """See `PairBackend`."""
        tasks = self.tasks(query)
        if len(tasks) == 1:
            return self.of_task(tasks[0], query, begin, end, max_pairs, progress)
        found: list[PairColumns] = []
        for at, task in enumerate(tasks):
            share = staged(progress, MERGE_AT * at / len(tasks), MERGE_AT * (at + 1) / len(tasks))
            columns = self.of_task(task, query, begin, end, max_pairs - sum(len(each[0]) for each in found), share)
            if len(columns[0]):
                found.append(columns)
            if share is not None:
                share(1.0)
        return merged(found, staged(progress, MERGE_AT, 1))

    def tasks(self, query: PairQuery) -> list[PairTask]:
        """Return the sets that may have pairs, so that those of one first set follow each other."""
        second = self.first if self.second is None else self.second
        if len(self.first) == len(second) == 1:
            return [PairTask(0, 0)]
        boxes = self.first.boxes().astype(np.float64)
        filled = np.flatnonzero(boxes[:, 0, 0] < np.inf)
        if not len(filled):
            return []
        low, high = boxes[filled, 0], boxes[filled, 1]
        reach = reach_of(query)
        with np.errstate(over="ignore"):
            offsets, near = second.near((low - reach).astype(np.float32), (high + reach).astype(np.float32))
        return [
            PairTask(int(i), int(j))
            for at, i in enumerate(filled)
            for j in np.sort(near[offsets[at] : offsets[at + 1]])
        ]

    def of_task(
        self,
        task: PairTask,
        query: PairQuery,
        begin: int,
        end: int,
        max_pairs: int,
        progress: ProgressCallback | None,
    ) -> PairColumns:
        """Return the pairs of two sets whose first primitives are from begin up to end."""
        is_self = self.second is None
        is_one = is_self and task.first == task.second
        first = self.first.open(task.first, with_places=query.reach > 0)
        begin, end = first.range(begin, end)
        if begin >= end:
            return no_pairs()
        second = first if is_one else (self.second or self.first).open(task.second, with_places=query.reach > 0)
        is_parts = is_self and not is_one
        if not len(second.geometry) or (is_parts and first.number(begin) > second.number(-1)):
            return no_pairs()
        known = first.rows(of_whole=is_parts), second.rows(of_whole=is_parts)
        i, j, s, t, distance = engine.pairs(
            first.view,
            None if is_one else second.view,
            known,
            query.options(begin, end, max_pairs),
            get_num_threads(),
            progress,
        )
        i, s = first.named(i, s)
        j, t = second.named(j, t)
        return i, j, s, t, distance


def merged(found: Sequence[PairColumns], progress: ProgressCallback | None) -> PairColumns:
    """Merge sorted pairs; none is in two of the lists."""
    if len(found) < 2:
        return found[0] if found else no_pairs()
    columns: PairColumns = _core.merge_pairs(list(found), get_num_threads(), progress)
    return columns
