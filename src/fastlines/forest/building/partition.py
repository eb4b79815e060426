"""Partition: the rows of some chunks at a time are sorted by the leaf of the scene that they are in."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...arrays import AnyArray, IntArray
from ...progress import ProgressCallback
from ...threads import map_in_threads
from .halving import centroids_of
from .journal import Journal
from .plan import Plan
from .rows import Rows, joined
from .spill import CLOSED, SKIPPED
from .stage_file import read_stage, write_stage

#: How many rows of a part are in each leaf; and the number of each row in its part, a column.
COUNTS, IDS = ".counts", "ids"


@dataclass(frozen=True)
class TileRows:
    """Which rows are a tile: those of a leaf, from one to another in the order of their numbers."""

    leaf: int
    begin: int
    end: int

    def __len__(self) -> int:
        return self.end - self.begin


def partition(journal: Journal, plan: Plan, at_once: int, progress: ProgressCallback | None) -> None:
    """Write the parts that are missing, so many at a time, and remove their chunks."""
    if journal.partitioned.exists():
        return
    missing = [number for number in range(plan.n_parts) if not journal.part(number).exists()]
    n_done = plan.n_parts - len(missing)
    for _ in map_in_threads(lambda number: _write_part(journal, plan, number), missing, at_once):
        n_done += 1
        if progress is not None:
            progress(n_done / plan.n_parts)
    # A chunk whose part was there, of a build that was killed in between.
    for number in range(len(plan.first) - 1):
        _remove(journal, number)
    counts = np.stack([read_stage(journal.part(number))[0][COUNTS] for number in range(plan.n_parts)])
    write_stage(journal.partitioned, {"counts": counts}, {})


def tiles_of(journal: Journal, most: int) -> list[TileRows]:
    """Return the rows of each tile; a leaf with more rows than a tile may have becomes several, runs of its numbers."""
    tiles = []
    for leaf, count in enumerate(read_stage(journal.partitioned)[0]["counts"].sum(axis=0).tolist()):
        n_tiles = -(-count // most)
        bounds = [count * i // n_tiles for i in range(n_tiles)] + [count]
        tiles += [TileRows(leaf, begin, end) for begin, end in pairwise(bounds)]
    return tiles


def _write_part(journal: Journal, plan: Plan, number: int) -> None:
    """Sort the rows of the chunks of a part."""
    begin, end = plan.batches[number : number + 2].tolist()
    parts: list[Rows] = []
    others: dict[str, list[AnyArray]] = {SKIPPED: [], CLOSED: []}
    for chunk in range(begin, end):
        arrays, _ = read_stage(journal.chunk(chunk))
        parts.append(Rows.of_sections(arrays))
        for name, found in others.items():
            found.append(arrays[name])
    rows = joined(parts, plan.schema)
    del parts
    order, counts = plan.halving.sort(centroids_of(rows.columns["segments"]))
    arrays = {
        **rows.taken(order).sections(),
        IDS: order.astype(np.uint32),
        COUNTS: counts,
        **{name: np.concatenate(found) for name, found in others.items()},
    }
    write_stage(journal.part(number), arrays, {})
    del rows, arrays, others, found  # which map the chunks
    for chunk in range(begin, end):
        _remove(journal, chunk)


def _remove(journal: Journal, chunk: int) -> None:
    with contextlib.suppress(FileNotFoundError):
        journal.chunk(chunk).unlink()


def gathered(journal: Journal, plan: Plan, tile: TileRows) -> tuple[Rows, IntArray]:
    """Return the rows of a tile, and their numbers, rising."""
    counts = read_stage(journal.partitioned)[0]["counts"]
    here = counts[:, tile.leaf]
    first_row = counts[:, : tile.leaf].sum(axis=1)
    before = np.cumsum(here) - here
    parts: list[Rows] = []
    ids: list[IntArray] = [np.empty(0, np.int64)]
    for number in np.flatnonzero((before < tile.end) & (before + here > tile.begin)).tolist():
        begin = max(tile.begin - before[number], 0)
        end = min(tile.end - before[number], here[number])
        arrays, _ = read_stage(journal.part(number))
        rows = Rows.of_sections(arrays).cut(first_row[number] + begin, first_row[number] + end)
        ids.append(rows.columns.pop(IDS) + plan.first[plan.batches[number]])
        parts.append(rows)
    return joined(parts, plan.schema), np.concatenate(ids)
