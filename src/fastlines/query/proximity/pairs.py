"""Pairs of near primitives: the answer of `Tree.pairs`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arrays import FloatArray, IntArray
from ...geometry.any_geometry import AnyGeometry
from ...geometry.hit_places import Float64Array, HitPlaces, HitRays
from ...support.computed_once import computed_once
from ...support.immutable import own
from ...support.texts import counted
from ..answer import Answer


@dataclass(frozen=True, eq=False, repr=False)
class Pairs(Answer):
    """Pairs of primitives within a radius of each other, sorted by (i, j); `Tree.pairs` finds them.

    Attributes
    ----------
    i, j : (n,) int64
        The two primitives. In pairs of one tree i < j; with another tree, j counts the primitives of that. In a
        `Geometry` they count over all parts, as ``hits.prim_number`` does; `part_i` and `part_j` are the parts.
    s, t : (n,) float32
        Where i is nearest to j, from 0 to 1 along it, and where j is nearest to i.
    distance : (n,) float32
        How far these places are from each other; less both radii there with ``to="surface"``, and then negative where
        primitives overlap.
    surface : bool
        Whether distances are to surfaces.
    geometry, other : Lines, Geometry or another container, or None
        What i counts, and what j counts. A pickle has `row_i`, `row_j`, `strand_i` and `strand_j` in their place.

    Examples
    --------
    >>> import fastlines as fl
    >>> rods = fl.Lines.from_segments([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 3], [0, 1, 3]]], radius=[1, 1])
    >>> pairs = fl.build(rods).pairs(2)
    >>> print(pairs.i, pairs.j, pairs.s, pairs.t, pairs.distance)
    [0] [1] [0.5] [0.5] [1.]
    """

    i: IntArray
    j: IntArray
    s: FloatArray
    t: FloatArray
    distance: FloatArray
    surface: bool
    geometry: AnyGeometry | None = None
    other: AnyGeometry | None = None

    _unpickled = ("geometry", "other")
    _in_pickles = ("row_i", "row_j", "strand_i", "strand_j")

    def __len__(self) -> int:
        return len(self.i)

    def __repr__(self) -> str:
        return f"<Pairs: {counted(len(self), 'pairs')}>"

    def __getitem__(self, rows: Any) -> Pairs:
        """Return some of the pairs: by a slice, an array of positions, a mask, or one position."""
        columns = self.i, self.j, self.s, self.t, self.distance
        i, j, s, t, distance = (column[rows].reshape(-1) for column in columns)
        found = Pairs(i, j, s, t, distance, self.surface, self.geometry, self.other)
        if self.geometry is None:  # of a pickle, which has these in its place
            found.__dict__.update({name: own(getattr(self, name)[rows].reshape(-1)) for name in self._in_pickles})
        return found

    @computed_once
    def strand_i(self) -> IntArray:
        """The strand of each i, (n,) int64; -1 for none. Each part of a `Geometry` counts its own strands."""
        return own(self._known().strands_of(self.i))

    @computed_once
    def strand_j(self) -> IntArray:
        """The strand of each j, (n,) int64; -1 for none."""
        return own(self._second().strands_of(self.j))

    @property
    def part_i(self) -> IntArray | None:
        """The part of a `Geometry` that each i is of, (n,) int64; None for a single container."""
        return self._known().split(self.i)[0]

    @property
    def part_j(self) -> IntArray | None:
        """The part of a `Geometry` that each j is of, (n,) int64; None for a single container."""
        return self._second().split(self.j)[0]

    @computed_once
    def row_i(self) -> IntArray:
        """The row of the input that each i was, (n,) int64; it differs from i where rows of the input were skipped."""
        return own(self._known().rows_of(self.i))

    @computed_once
    def row_j(self) -> IntArray:
        """The row of the input that each j was, (n,) int64."""
        return own(self._second().rows_of(self.j))

    def points(self) -> Float64Array:
        """Return the nearest points of each pair, (n, 2, 3) float64: that of i, then that of j.

        They are on the axes; with ``to="surface"`` on the surfaces, on the line through both axes. The offset of the
        lines is added.

        Examples
        --------
        >>> import fastlines as fl
        >>> rods = fl.Lines.from_segments([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 3], [0, 1, 3]]], radius=[1, 1])
        >>> fl.build(rods).pairs(2).points()[0].tolist()
        [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]
        """
        first, second = self._known(), self._second()
        at = [HitPlaces.without_rays(prim, u.astype(np.float64)) for prim, u in ((self.i, self.s), (self.j, self.t))]
        axes = [of.nearest_at(places, False) for of, places in zip((first, second), at, strict=True)]
        if self.surface:
            towards = [replace(places, rays=HitRays.of_points(to)) for places, to in zip(at, axes[::-1], strict=True)]
            axes = [of.nearest_at(places, True) for of, places in zip((first, second), towards, strict=True)]
        return np.asarray(np.stack(axes, axis=1) + np.array(first.offset))

    def _second(self) -> AnyGeometry:
        """Return what the second primitives are of."""
        self._known()
        assert self.other is not None
        return self.other
