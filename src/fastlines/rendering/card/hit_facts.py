"""What a card says about hits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arrays import AnyArray, IntArray
from ...query.hits import AllHits, FirstHits
from ...support.distinct import distinct
from ...support.texts import listed, range_text
from .facts import Fact


def hit_facts(hits: FirstHits | AllHits) -> Iterator[Fact]:
    """Yield what is known of the answer of a query.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    >>> dict(hit_facts(tree.first_hit([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)))["that hit"]
    '1, 50 %'
    """
    if isinstance(hits, FirstHits):
        n_rays, n_that_hit, shape = hits.prim.size, int(hits.hit.sum()), hits.prim.shape
    else:
        counts = hits.counts
        n_rays, n_that_hit, shape = len(counts), int((counts > 0).sum()), counts.shape
    yield "rays", f"{n_rays:,}" + (f", {' × '.join(map(str, shape))}" if len(shape) > 1 else "")
    if n_rays:
        yield "that hit", f"{n_that_hit:,}, {100 * n_that_hit / n_rays:.3g} %"
    if isinstance(hits, AllHits) and n_rays:
        yield "hits", f"{len(hits):,}, {len(hits) / n_rays:.3g} a ray, {int(hits.counts.max()):,} at most"
    if len(hits.skipped):
        yield "invalid rays", f"{len(hits.skipped):,}, which miss"
    found = hits.prim >= 0
    if found.any():
        part = 0 if hits.part is None else hits.part[found]
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
