"""A sample of a geometry: the few primitives that stand for many in a thumbnail."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from ...geometry.boxes import Boxes
from ...geometry.collection import AnyGeometry, Part, parts_of
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ...geometry.spheres import Spheres
from ...geometry.triangles import Triangles
from ...geometry.user_primitives import UserPrimitives

#: About the most primitives of a sample.
MAX_DRAWN = 20_000
#: Lines are taken in runs of this many consecutive ones, which often belong to one strand.
RUN = 32
#: The number of chords that a curve is drawn with.
CHORDS = 8


@dataclass(frozen=True)
class Sketch:
    """Lines, spheres, triangles and boxes to draw, and how many primitives they stand for."""

    parts: tuple[Part, ...]
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
    drawn, n_drawn = list[Part](), 0
    for part in parts_of(geometry):
        share = most if n_prims <= most else max(RUN, int(most * len(part) / n_prims))
        chords = CHORDS if isinstance(part, Curves) else 1
        rows = spaced_rows(len(part), max(1, share // chords), 1 if isinstance(part, Spheres) else RUN)
        drawn += _drawn(part, rows)
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


def _drawn(part: AnyGeometry, rows: IntArray) -> Iterator[Part]:
    """Yield some rows of a container, as lines, spheres, triangles or boxes."""
    if isinstance(part, Curves):
        yield _chords(part, rows)
    elif isinstance(part, Lines):
        radius = None if part.radius is None else part.radius[rows]
        yield type(part)(part.segments[rows], radius=radius, up=part.up)
    elif isinstance(part, Triangles | Boxes):
        yield type(part)(part.corners[rows])
    elif isinstance(part, UserPrimitives):
        # Only the boxes of primitives of your own are known, perhaps several of each.
        of_rows = np.isin(part.owner, rows)
        yield Boxes(part.core_rows[of_rows, :6].reshape(-1, 2, 3))


def _chords(curves: Curves, rows: IntArray) -> Lines:
    """Return a few chords of each curve."""
    at = curves.evaluate(rows[:, None], np.linspace(0, 1, CHORDS + 1))
    ends = _ends(np.asarray(at.points, np.float32)).reshape(-1, 2, 3)
    radii = None if curves.radius is None else _ends(np.asarray(at.radius, np.float32)).reshape(-1, 2)
    return Lines(np.ascontiguousarray(ends), radius=radii, up=curves.up)


def _ends(values: FloatArray) -> FloatArray:
    """Pair each value along axis 1 with the next one."""
    return np.stack([values[:, :-1], values[:, 1:]], axis=2)
