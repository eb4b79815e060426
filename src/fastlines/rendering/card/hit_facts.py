"""What a card says about the answer of a query."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arrays import AnyArray, IntArray
from ...query.compressed_rows import CompressedRows
from ...query.found_prims import FoundPrims
from ...query.hit_geometry import HitGeometry
from ...query.prim_numbers import PrimNumbers
from ...query.proximity.along import Along
from ...query.proximity.in_box import InBox
from ...query.proximity.near_prims import NearPrims
from ...query.proximity.nearest import Nearest
from ...query.proximity.pairs import Pairs
from ...support.distinct import distinct
from ...support.texts import listed, range_text
from .facts import Fact


def hit_facts(hits: PrimNumbers | Pairs) -> Iterator[Fact]:
    """Yield what is known of the answer of a query.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    >>> dict(hit_facts(tree.first_hit([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)))["that hit"]
    '1, 50 %'
    """
    if isinstance(hits, Pairs):
        yield from _pair_facts(hits)
        return
    if not isinstance(hits, Along):
        yield from _facts_of_queries(hits)
    found = hits.prim >= 0
    if found.any():
        part = 0 if hits.part is None else hits.part[found]
        if isinstance(hits, HitGeometry):
            yield "t", _range(hits.t[found]) + (", at surfaces" if hits.t_out is not None else "")
        if isinstance(hits, FoundPrims):
            yield "distance", _range(hits.distance[found])
        yield "different prims", f"{_count_different(hits.prim[found], part):,}"
        if hits.geometry is not None and hits.geometry.n_strands:
            yield "different strands", f"{_count_different(hits.strand[found], part):,}"
        if hits.part is not None:
            pairs = zip(*np.unique(part, return_counts=True), strict=True)
            yield "hits of parts", listed(f"{number}: {n:,}" for number, n in pairs)
    if hits.geometry is not None:
        yield "of", hits.geometry.count_text()


def _facts_of_queries(hits: PrimNumbers) -> Iterator[Fact]:
    """Yield how many rays, points or boxes there are, and how much each has."""
    noun, nouns, with_any, entries = "ray", "rays", "that hit", "hits"
    if isinstance(hits, NearPrims | InBox):
        noun, nouns = ("box", "boxes") if isinstance(hits, InBox) else ("point", "points")
        with_any, entries = "with an answer", "answers"
    counts = hits.counts if isinstance(hits, CompressedRows | Nearest) else (hits.prim >= 0).astype(int)
    n, shape, n_with_any, n_found = counts.size, counts.shape, int((counts > 0).sum()), int(counts.sum())
    yield nouns, f"{n:,}" + (f", {' × '.join(map(str, shape))}" if len(shape) > 1 else "")
    if n:
        yield with_any, f"{n_with_any:,}, {100 * n_with_any / n:.3g} %"
    if n and (isinstance(hits, CompressedRows) or (isinstance(hits, Nearest) and hits.k != 1)):
        yield entries, f"{n_found:,}, {n_found / n:.3g} a {noun}, {int(counts.max()):,} at most"
    if isinstance(hits, HitGeometry | NearPrims) and len(hits.skipped):
        yield f"invalid {nouns}", f"{len(hits.skipped):,}, which miss"


def _pair_facts(pairs: Pairs) -> Iterator[Fact]:
    """Yield what is known of pairs."""
    yield "pairs", f"{len(pairs):,}"
    if len(pairs):
        yield "distance", _range(pairs.distance) + (", of surfaces" if pairs.surface else "")
    if pairs.geometry is not None and pairs.other is not None:
        both = (pairs.geometry,) if pairs.other is pairs.geometry else (pairs.geometry, pairs.other)
        yield "of", " and ".join(each.count_text() for each in both)


def _range(values: AnyArray) -> str:
    return range_text(float(values.min()), float(values.max()))


def _count_different(numbers: IntArray, part: IntArray | int) -> int:
    """Count the different numbers of all parts; -1 is none."""
    keys = part * (numbers.max() + 1) + numbers
    return len(distinct(keys[numbers >= 0]))
