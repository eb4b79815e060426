"""A sample of a geometry: the few primitives that stand for many in a thumbnail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import IntArray
from ...geometry.any_geometry import AnyGeometry

#: About the most primitives of a sample.
MAX_DRAWN = 20_000
#: The least share of a part in a sample of several.
LEAST = 32


@dataclass(frozen=True)
class Sketch:
    """Lines, spheres, triangles and boxes to draw, and how many primitives they stand for."""

    parts: tuple[AnyGeometry, ...]
    n_drawn: int
    n_prims: int

    @property
    def caption(self) -> str:
        """Whether this is a sample, in words; empty where everything is drawn."""
        return f"a sample of {self.n_drawn:,} of {self.n_prims:,}" if self.n_drawn < self.n_prims else ""


def sketch(geometry: AnyGeometry, most: int = MAX_DRAWN) -> Sketch:
    """Take about `most` primitives, evenly over all parts of a geometry.

    Examples
    --------
    >>> import fastlines as fl
    >>> sketch(fl.scenes.make("spaghetti", 50_000).lines, 1000).caption
    'a sample of 992 of 50,000'
    """
    n_prims = len(geometry)
    drawn, n_drawn = list[AnyGeometry](), 0
    for part in geometry.each_part():
        share = most if n_prims <= most else max(LEAST, int(most * len(part) / n_prims))
        rows = spaced_rows(len(part), max(1, share // part.strokes), part.run)
        drawn += part.drawn(rows)
        n_drawn += len(rows)
    return Sketch(tuple(drawn), n_drawn, n_prims)


def spaced_rows(n: int, most: int, run: int = 1) -> IntArray:
    """Return at most `most` of n rows, in runs of consecutive ones that are spaced evenly.

    Examples
    --------
    >>> spaced_rows(100, 6, run=2)
    array([ 0,  1, 49, 50, 98, 99])
    """
    if n <= most:
        return np.arange(n)
    run = min(run, most)
    starts = np.linspace(0, n - run, max(1, most // run)).astype(np.int64)
    return np.asarray((starts[:, None] + np.arange(run)).ravel())
