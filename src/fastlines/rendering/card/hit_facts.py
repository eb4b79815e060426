"""What a card says about the answer of a query."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arrays import AnyArray, IntArray
from ...query.compressed_rows import CompressedRows
from ...query.found_prims import FoundPrims
from ...query.hit_geometry import HitGeometry
from ...query.proximity.near_prims import NearPrims
from ...support.distinct import distinct
from ...support.texts import listed, range_text
from .facts import Fact


def hit_facts(hits: FoundPrims) -> Iterator[Fact]:
    """Yield what is known of the answer of a query.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    >>> dict(hit_facts(tree.first_hit([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)))["that hit"]
    '1, 50 %'
    """
    is_near = isinstance(hits, NearPrims)
    noun, with_any, entries = ("point", "with an answer", "answers") if is_near else ("ray", "that hit", "hits")
    per_row = hits.counts if isinstance(hits, CompressedRows) else hits.prim >= 0
    shape, n_that_hit = per_row.shape, int((per_row > 0).sum())
    yield f"{noun}s", f"{per_row.size:,}" + (f", {' × '.join(map(str, shape))}" if len(shape) > 1 else "")
    if per_row.size:
        yield with_any, f"{n_that_hit:,}, {100 * n_that_hit / per_row.size:.3g} %"
    if isinstance(hits, CompressedRows) and per_row.size:
        each = f"{len(hits) / per_row.size:.3g} a {noun}, {int(per_row.max()):,} at most"
        yield entries, f"{len(hits):,}, {each}"
    if len(hits.skipped):
        yield f"invalid {noun}s", f"{len(hits.skipped):,}, which miss"
    found = hits.prim >= 0
    if found.any():
        part = 0 if hits.part is None else hits.part[found]
        if isinstance(hits, HitGeometry):
            yield "t", _range(hits.t[found]) + (", at surfaces" if hits.t_out is not None else "")
        yield "distance", _range(hits.distance[found])
        yield "different prims", f"{_count_different(hits.prim[found], part):,}"
        if hits.geometry is not None and hits.geometry.n_strands:
            yield "different strands", f"{_count_different(hits.strand[found], part):,}"
        if hits.part is not None:
            pairs = zip(*np.unique(part, return_counts=True), strict=True)
            yield "hits of parts", listed(f"{number}: {n:,}" for number, n in pairs)
    if hits.geometry is not None:
        yield "of", hits.geometry.count_text()


def _range(values: AnyArray) -> str:
    return range_text(float(values.min()), float(values.max()))


def _count_different(numbers: IntArray, part: IntArray | int) -> int:
    """Count the different numbers of all parts; -1 is none."""
    keys = part * (numbers.max() + 1) + numbers
    return len(distinct(keys[numbers >= 0]))
