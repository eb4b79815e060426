"""What is drawn of a geometry: straight strokes, and the primitive and the place on it of each end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ..arrays import AnyArray, FloatArray, IntArray
from ..geometry.any_geometry import AnyGeometry
from ..geometry.hit_places import Float64Array
from ..support.distinct import distinct, is_among
from ..support.texts import counted
from .thinning import MAX_SHOWN, thinned_rows

#: The ends, the primitives, the places and the radii of strokes.
Columns: TypeAlias = tuple[FloatArray, IntArray, FloatArray, FloatArray]
#: Of each part, so many primitives are shown at least.
MIN_SHOWN = 1
#: The chords of each of the three circles that draw a sphere.
CHORDS = 16


@dataclass(frozen=True, eq=False)
class Strokes:
    """Straight strokes of some primitives.

    Attributes
    ----------
    ends : (n, 2, 3) float32
        Both ends, without the offset of the geometry.
    prims : (n,) int64
        The primitive of each, counted over all parts.
    places : (n, 2) float32
        Where both ends are: u on the axis of a line or curve, or else the number of the corner.
    radii : (n, 2) float32
        The radius of their own at both ends; 0 without one.
    n_shown, n_cut, n_prims : int
        How many primitives are drawn, how many the cut planes hide, and how many there are.
    noun : str
        What the primitives are called.
    """

    ends: FloatArray
    prims: IntArray
    places: FloatArray
    radii: FloatArray
    n_shown: int
    n_cut: int
    n_prims: int
    noun: str

    @property
    def caption(self) -> str:
        """How many primitives are shown, in words."""
        if self.n_shown == self.n_prims:
            return f"{counted(self.n_prims, self.noun)}, all shown"
        cut = f"; the cut planes hide {self.n_cut:,}" if self.n_cut else ""
        return f"{self.n_shown:,} of {counted(self.n_prims, self.noun)} are shown{cut}; queries use all"


def strokes_of(geometry: AnyGeometry, most: int = MAX_SHOWN, slab: Float64Array | None = None) -> Strokes:
    """Return strokes that draw a geometry, thinned to about `most`.

    Parameters
    ----------
    geometry : Lines, Curves, Geometry or another container
    most : int
    slab : (2, 3) array, optional
        Draw only what has its middle between these corners, without the offset.

    Examples
    --------
    >>> import fastlines as fl
    >>> strokes_of(fl.scenes.make("spaghetti", 50_000).lines, 1000).caption
    '1,000 of 50,000 segments are shown; queries use all'
    >>> strokes_of(fl.Spheres.from_centres([[0, 0, 0]], radius=1)).ends.shape
    (48, 2, 3)
    """
    parts, n_prims = geometry.each_part(), len(geometry)
    wanted = sum(len(part) * _strokes_each(part) for part in parts)
    columns, n_shown, n_cut, first = [_nothing()], 0, 0, 0
    for part in parts:
        rows = None
        if slab is not None and (axes := part.thick_axes()) is not None:
            middles = axes[0].sum(axis=1, dtype=np.float32) / 2
            rows = distinct(part.owner[_between(middles, slab)])
            n_cut += len(part) - len(rows)
        share = min(1.0, most / max(1, wanted))
        chosen = thinned_rows(part, max(MIN_SHOWN, int(len(part) * share)), rows)
        ends, of_rows, places, radii = _strokes(part, chosen)
        if slab is not None and rows is None:
            kept = is_among(of_rows, distinct(of_rows[_between(ends.mean(axis=1), slab)]))
            ends, of_rows, places, radii = ends[kept], of_rows[kept], places[kept], radii[kept]
            hidden = len(chosen) - len(distinct(of_rows))
            n_cut += hidden
            n_shown -= hidden
        n_shown += len(chosen)
        columns.append((ends, of_rows + first, places, radii))
        first += len(part)
    noun = "primitives" if geometry.has_parts else geometry.noun
    return Strokes(*_joined(columns), n_shown, n_cut, n_prims, noun)


def strokes_of_prims(geometry: AnyGeometry, prims: IntArray) -> Float64Array:
    """Return strokes that draw some primitives, which are counted over all parts, (n, 2, 3)."""
    found, first = [np.empty((0, 2, 3))], 0
    for part in geometry.each_part():
        here = (first <= prims) & (prims < first + len(part))
        found.append(_strokes(part, prims[here] - first)[0].astype(np.float64))
        first += len(part)
    return np.concatenate(found)


def _strokes_each(part: AnyGeometry) -> int:
    """Return how many strokes draw one primitive."""
    return max(1, len(_strokes(part, np.arange(min(1, len(part))))[0]))


def _strokes(part: AnyGeometry, rows: IntArray) -> Columns:
    """Return the ends, the primitives, the places and the radii of strokes that draw some primitives of a part."""
    columns = [_nothing()]
    for shapes in part.drawn(rows) if len(rows) else ():
        corners, radii = shapes.outlines()
        n, k = corners.shape[:2]
        owners = rows if n % len(rows) == 0 else part.owner[is_among(part.owner, rows)]
        of_rows, per = np.repeat(owners, n // len(owners)), n // len(owners)
        if k > 2:
            edges = np.stack([np.arange(k), (np.arange(k) + 1) % k], axis=1)
            ends, radii = corners[:, edges].reshape(-1, 2, 3), radii[:, edges].reshape(-1, 2)
            columns.append(_column(ends, np.repeat(of_rows, k), np.tile(edges, (n, 1)), radii))
        elif not part.has_directions:
            circles = (corners[:, :1, None] + radii[:, :1, None, None] * _circles()).reshape(-1, 2, 3)
            each = len(circles) // n
            columns.append(
                _column(circles, np.repeat(of_rows, each), np.zeros((n * each, 2)), np.repeat(radii, each, 0))
            )
        else:
            u = np.linspace(0, 1, per + 1)
            columns.append(
                _column(corners, of_rows, np.tile(np.stack([u[:-1], u[1:]], axis=1), (len(owners), 1)), radii)
            )
    return _joined(columns)


def _column(ends: Float64Array, rows: IntArray, places: AnyArray, radii: Float64Array) -> Columns:
    return ends.astype(np.float32), rows, places.astype(np.float32), radii.astype(np.float32)


def _joined(columns: list[Columns]) -> Columns:
    ends, rows, places, radii = zip(*columns, strict=True)
    return np.concatenate(ends), np.concatenate(rows), np.concatenate(places), np.concatenate(radii)


def _nothing() -> Columns:
    return _column(np.empty((0, 2, 3)), np.empty(0, np.int64), np.empty((0, 2)), np.empty((0, 2)))


def _circles() -> Float64Array:
    """Return the chords of three circles around the axes, (1, n, 2, 3)."""
    turns = np.linspace(0, 2 * np.pi, CHORDS + 1)
    circle = np.stack([np.cos(turns), np.sin(turns), np.zeros(CHORDS + 1)], axis=1)
    chords = np.stack([circle[:-1], circle[1:]], axis=1)
    return np.concatenate([np.roll(chords, axis, axis=2) for axis in range(3)])[None]


def _between(points: FloatArray, slab: Float64Array) -> IntArray:
    """Return the rows of points between the corners of a slab."""
    inside = np.ones(len(points), np.bool_)
    for axis in range(3):
        inside &= (slab[0, axis] <= points[:, axis]) & (points[:, axis] <= slab[1, axis])
    return np.flatnonzero(inside)
