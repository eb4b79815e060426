"""Which primitives are shown where there are more than a browser draws."""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray
from ..geometry.any_geometry import AnyGeometry
from ..rendering.card.sketch import spaced_rows

#: The most strokes on the page, and in a page that is exported.
MAX_SHOWN, MAX_EXPORTED = 200_000, 60_000
#: Strands are shown whole if the longest has at most this fraction of what is shown.
SHORT = 0.1


def thinned_rows(part: AnyGeometry, most: int, rows: IntArray | None = None) -> IntArray:
    """Return at most `most` primitives of a container, or of some rows of it, spaced evenly.

    Whole strands are taken where all are short, and else runs of consecutive primitives, so that lines stay continuous.

    Examples
    --------
    >>> import fastlines as fl
    >>> hair = fl.Lines.from_strands(np.random.default_rng(0).uniform(0, 1, (100, 4, 3)))  # 100 strands of 3 segments
    >>> thinned_rows(hair, 60)[:7]
    array([ 0,  1,  2, 15, 16, 17, 30])
    """
    rows = np.arange(len(part)) if rows is None else rows
    if len(rows) <= most:
        return rows
    strands = part.strands_of(rows)
    first = np.flatnonzero(np.concatenate([[True], strands[1:] != strands[:-1]]))
    sizes = np.diff(first, append=len(rows))
    if strands[0] < 0 or sizes.max() > SHORT * most:
        return np.asarray(rows[spaced_rows(len(rows), most, part.run)])
    chosen = np.linspace(0, len(first), int(len(first) * most / len(rows)), endpoint=False).astype(np.int64)
    chosen = chosen[np.cumsum(sizes[chosen]) <= most]
    begin = np.cumsum(sizes[chosen]) - sizes[chosen]
    return np.asarray(rows[np.repeat(first[chosen] - begin, sizes[chosen]) + np.arange(int(sizes[chosen].sum()))])
