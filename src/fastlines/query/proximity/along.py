"""Primitives along a polyline: the answer of `Tree.along`, and how it is found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _core
from ...arrays import COORDINATE_LIMIT, FloatArray, IntArray, to_float64
from ...engines import engine
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...geometry.hit_places import Float64Array
from ...geometry.offsets import NO_OFFSET
from ...progress import ProgressCallback, staged
from ...support.distinct import distinct
from ...support.texts import counted
from ...threads import get_num_threads
from ..found_prims import FoundPrims
from ..rays import warn_of_coarse
from .pair_query import PairColumns, PairQuery, most_pairs, no_pairs, reach_of
from .pair_sets import PairSets


@dataclass(frozen=True, eq=False, repr=False)
class Along(FoundPrims):
    """The primitives within a radius of a polyline, each once, sorted by number; `Tree.along` finds them.

    Attributes
    ----------
    prim : (n,) int64
        The primitives. In a `Geometry` they count within their `part`.
    u : (n,) float32
        Where each is nearest to the polyline, from 0 to 1 along the primitive.
    distance : (n,) float32
        How far it is from the polyline; less its radius there with ``to="surface"``.
    segment : (n,) int64
        The segment of the polyline that it is nearest to; of several equally near ones the first.
    s : (n,) float32
        The place on that segment, from 0 to 1.
    geometry : Lines, Geometry or another container, or None
        What the tree is over. A pickle has `row` and `strand` in its place.
    part : (n,) int64 or None
        The part of a `Geometry`.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.Lines.from_strands([[[0, 0, 0], [4, 0, 0]], [[2, 3, 0], [2, 5, 0]], [[9, 9, 0], [9, 9, 9]]])
    >>> found = fl.build(lines).along([[1, 1, 0], [1, 4, 0], [6, 4, 0]], radius=1)
    >>> print(found.prim, found.strand, found.distance, found.segment, found.s)
    [0 1] [0 1] [1. 0.] [0 1] [0.  0.2]
    """

    prim: IntArray
    u: FloatArray
    distance: FloatArray
    segment: IntArray
    s: FloatArray
    geometry: AnyGeometry | None = None
    part: IntArray | None = None

    def __len__(self) -> int:
        return len(self.prim)

    def __repr__(self) -> str:
        return f"<Along: {counted(len(self), 'primitives')}>"

    @property
    def position(self) -> Float64Array:
        """The place on the polyline as one number, (n,) float64: `segment` + `s`, to sort by."""
        return np.asarray(self.segment + self.s.astype(np.float64))

    def points(self) -> Float64Array:
        """Return the point of the axis of each primitive that is nearest to the polyline, (n, 3) float64."""
        geometry = self._known()
        return np.asarray(geometry.nearest_at(self._places(on_rays=False), False) + np.array(geometry.offset))


def find_along(polyline: npt.ArrayLike, query: PairQuery, sets: PairSets, callback: ProgressCallback | None) -> Along:
    """Find what is along a polyline."""
    geometry, points = query.geometry, polyline_points(polyline, query.geometry)
    columns = no_pairs() if query.is_empty else parts_near(points, query).pairs(query, sets, callback)
    segment, prim, s, u, distance = columns
    # Keep the best segment of each primitive.
    order = np.lexsort((segment, distance, prim))
    best = order[np.diff(prim[order], prepend=-1) > 0]
    part, found = geometry.split(prim[best].view(np.int64))
    return Along(found, u[best], distance[best], segment[best].view(np.int64), s[best], geometry, part)


def polyline_points(polyline: npt.ArrayLike, geometry: AnyGeometry) -> Float64Array:
    """Check a polyline, and return its points less the offset of the lines, (m, 3)."""
    given = to_float64(polyline, "polyline")
    if given.ndim != 2 or given.shape[1] != 3 or len(given) < 2:
        raise InputError(f"polyline has shape {given.shape}; expected (m, 3), with two points or more")
    points = given
    if geometry.offset != NO_OFFSET:
        points = given - np.array(geometry.offset)
        bounds = np.asarray(geometry.bounds, np.float32)
        warn_of_coarse("the points of a polyline", polyline, points, geometry.offset, bounds)
    bad = ~(np.abs(points) <= COORDINATE_LIMIT).all(axis=1)
    if bad.any():
        raise InputError(
            f"{int(bad.sum())} of {counted(len(points), 'points')} of the polyline hold NaN, Inf or a coordinate "
            f"beyond {COORDINATE_LIMIT:g}; leave them out"
        )
    return points


@dataclass(frozen=True, eq=False)
class NearParts:
    """The parts of the segments of a polyline that come near a scene: what is far away would make float32 coarse."""

    #: Both ends of each part, (n, 6).
    rows: FloatArray
    #: The segment of each part, and where on it the part begins and ends.
    segment: IntArray
    begin: Float64Array
    end: Float64Array

    def pairs(self, query: PairQuery, sets: PairSets, callback: ProgressCallback | None) -> PairColumns:
        """Find the pairs of a segment of the polyline and a primitive."""
        if not len(self.rows):
            return no_pairs()
        ends = self.rows.reshape(-1, 3)
        corners = np.concatenate([ends.min(axis=0), ends.max(axis=0)]).tolist()
        blocks, refs = np.zeros((0, 128), np.uint8), np.zeros((0, 2), np.uint32)
        needle = _core.LayoutView("segments", self.rows, blocks, blocks, refs, corners, corners, 0.0)
        near = np.zeros(1, np.int64) if len(sets) == 1 else self._near(sets, reach_of(query))
        found, n_left = [no_pairs()], most_pairs()
        for at, number in enumerate(near):
            of = sets.open(int(number), with_places=False)
            if not len(of.geometry):
                continue
            share = staged(callback, at / len(near), (at + 1) / len(near))
            known = (None, None, None), of.rows(of_whole=False)
            options = query.options(0, len(self.rows), n_left)
            part, row, s, u, distance = engine.pairs(needle, of.view, known, options, get_num_threads(), share)
            prim, u = of.named(row, u)
            found.append((part, prim, s, u, distance))
            n_left -= len(part)
            if share is not None:
                share(1.0)
        part, prim, s, u, distance = (np.concatenate(columns) for columns in zip(*found, strict=True))
        begin, end = self.begin[part], self.end[part]
        return self.segment[part], prim, np.asarray(begin + s * (end - begin), np.float32), u, distance

    def _near(self, sets: PairSets, reach: float) -> IntArray:
        """Return the sets whose boxes come near."""
        ends = self.rows.reshape(-1, 2, 3).astype(np.float64)
        corners = ends.min(axis=1) - reach, ends.max(axis=1) + reach
        return distinct(sets.near(*(corner.astype(np.float32) for corner in corners))[1])


def parts_near(points: Float64Array, query: PairQuery) -> NearParts:
    """Cut the segments between points to a box that holds all that a query can find, at least thrice the scene's."""
    low, high = query.geometry.bounds.astype(np.float64)
    margin = float((high - low).max() + max(abs(low).max(), abs(high).max())) + query.radius + query.geometry.max_radius
    start, step = points[:-1], np.diff(points, axis=0)
    # Find where each segment enters and leaves the slab of each axis.
    with np.errstate(divide="ignore", invalid="ignore"):
        planes = (np.stack([low - margin, high + margin])[:, None] - start) / step
    is_in = (low - margin <= start) & (start <= high + margin)
    planes[:, step == 0] = np.where(is_in[step == 0], [[-np.inf], [np.inf]], np.nan)
    begin = np.maximum(planes.min(axis=0).max(axis=1), 0)
    end = np.minimum(planes.max(axis=0).min(axis=1), 1)
    segment = np.flatnonzero(begin <= end)
    begin, end, start, step = begin[segment], end[segment], start[segment], step[segment]
    first, last = (start + at[:, None] * step for at in (begin, end))
    last = np.where(end[:, None] == 1, points[segment + 1], last)
    return NearParts(np.concatenate([first, last], axis=1).astype(np.float32), segment, begin, end)
