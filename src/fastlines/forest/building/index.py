"""The index of a forest that is built: the tile and the strand of each segment, in the order of their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray, IntArray
from ...geometry.lines import Lines
from ..index import SAMPLE_PRIMS, Index
from .journal import Journal
from .partition import COUNTS, IDS, TileRows
from .plan import Plan
from .rows import Rows, joined
from .spill import CLOSED, SKIPPED
from .stage_file import read_stage


def index_tiles(journal: Journal, plan: Plan, tiles: Sequence[TileRows], own_radius: bool = True) -> str:
    """Write the index, and return its digest; `own_radius` is that of the trees.

    The columns are written part by part and then mapped: they may not fit into memory.
    """
    leaf, begin, end = (
        np.array([getattr(tile, name) for tile in tiles], np.int64) for name in ("leaf", "begin", "end")
    )
    has_strands = "strands" in plan.schema
    strand_type = np.dtype(np.int32 if plan.n_numbers < 2**31 else np.int64)
    wanted = np.arange(n := min(SAMPLE_PRIMS, plan.n_prims)) * plan.n_prims // max(1, n)
    before = np.zeros(plan.halving.n_leaves, np.int64)
    sample: list[Rows] = []
    others: dict[str, list[AnyArray]] = {SKIPPED: [], CLOSED: []}
    with journal.column("tile_of").open("wb") as tile_file, journal.column("strands").open("wb") as strand_file:
        for number in range(plan.n_parts):
            arrays, _ = read_stage(journal.part(number))
            ids, counts = arrays[IDS], arrays[COUNTS]
            # Rows are in the order of tiles: count those of each.
            low, high = np.maximum(begin, before[leaf]), np.minimum(end, (before + counts)[leaf])
            tile = np.repeat(np.arange(len(tiles), dtype=np.uint32), np.maximum(high - low, 0))
            before += counts
            tile_file.write(_in_order(tile, ids).data)
            if has_strands:
                strand_file.write(_in_order(arrays["strands"].astype(strand_type), ids).data)
            sample.append(_rows_of(arrays, wanted, *plan.first[plan.batches[number : number + 2]].tolist()))
            for name, found in others.items():
                found.append(np.array(arrays[name]))  # not a view, which would keep the part mapped
    sampled = _lines(sample, plan)
    index = Index(
        _mapped(journal.column("tile_of"), np.dtype(np.uint32)),
        _mapped(journal.column("strands"), strand_type) if has_strands else None,
        np.concatenate(others[SKIPPED]),
        np.concatenate(others[CLOSED]),
        sampled if own_radius else sampled.without_radius(),
    )
    return index.write(journal.folder)


def _in_order(values: AnyArray, ids: AnyArray) -> AnyArray:
    """Return values in the order of the numbers of their rows."""
    found = np.empty_like(values)
    found[ids] = values
    return found


def _rows_of(arrays: dict[str, AnyArray], wanted: IntArray, first: int, end: int) -> Rows:
    """Return the wanted rows of a part, in the order of their numbers."""
    begin, stop = np.searchsorted(wanted, [first, end])
    place = _in_order(np.arange(end - first), arrays[IDS])
    rows = Rows.of_sections(arrays).taken(place[wanted[begin:stop] - first])
    del rows.columns[IDS]
    return rows


def _lines(sample: Sequence[Rows], plan: Plan) -> Lines:
    rows = joined(sample, plan.schema)
    rows.columns.pop("places", None)
    return rows.lines(plan.facts)


def _mapped(path: Path, dtype: np.dtype[Any]) -> AnyArray:
    """Map a column; an empty file cannot be mapped."""
    return np.memmap(path, dtype, "r") if path.stat().st_size else np.empty(0, dtype)
