"""The round cones that cubic curves are cut into, and the way from a place on a curve to one on its pieces and back.

A curve is the balls of radius r(u) around the points C(u), u from 0 to 1, with C and r cubic. Queries test round cones,
so each curve is cut into chords; `bezier.py` derives how far these are off.

**How far they may be off by default.** The tolerance is the smaller of

- 1 % of the local radius, so that a thin end is as exact as a thick one, for its size. The local radius is the least
  Bezier coefficient of the radius over the piece, but at least a tenth of the curve's largest radius: otherwise, a
  taper to a point would need pieces without end. Curves whose radius is nowhere above 0 have no local radius.
- 10⁻⁴ of the longest side of the curve's box: that of its control points, grown by its largest radius on all sides.

It is never below 2⁻²¹ of the curve's largest coordinate, which is what float32 costs. Each coordinate of a control
point is rounded by up to 2⁻²⁴ of that, which changes the bound by up to ¾·√3·4·2⁻²⁴. So a straight curve of one radius,
with evenly spaced control points, is one piece.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, FloatArray, IntArray, kind_of, list_rows
from ..errors import InputError, PrecisionWarning
from ..support.computed_once import computed_once
from ..support.immutable import Immutable, frozen, own
from ..support.texts import counted
from ..support.warn_caller import warn_caller
from .bezier import MAX_PIECES, UNITS, Chords, Float64Array, cut, largest
from .lines import Lines

#: The default tolerance as a fraction of the local radius, and of the longest side of the curve's box.
OF_RADIUS, OF_BOX = 0.01, 1e-4

#: The least local radius, as a fraction of the curve's largest radius.
LEAST_LOCAL = 0.1

#: What float32 costs, as a fraction of the curve's largest coordinate: no default tolerance is below it.
ROUNDING = 2.0**-21

#: So many curves are cut at a time, so that they stay in the cache.
BATCH = 1 << 11


@dataclass(frozen=True, eq=False)
class Pieces(Immutable):
    """The round cones that curves are cut into, in the order of the curves and along each of them.

    Attributes
    ----------
    lines : Lines
        The pieces, with the radius at both ends (if the curves have one), the strands, the unit, the upward axis and
        the metadata of their curves. Attributes stay with the curves: those of the pieces are
        ``curves.attributes[name][curve]``, with the array `curve` of the pieces.
    curve : (n_pieces,) int64
        The curve of each piece.
    first : (n_curves + 1,) int64
        The first piece of each curve, and the number of pieces.
    begin, end : (n_pieces,) float32
        The parameter of the curve at both ends: 0 at the first end of a curve, 1 at the last.
    deviation : (n_pieces,) float64
        How far each piece is from its part of the curve at most, before its ends are rounded to float32.
    """

    lines: Lines
    curve: IntArray
    first: IntArray
    begin: FloatArray
    end: FloatArray
    deviation: Float64Array

    def __post_init__(self) -> None:
        for name in ("curve", "first", "begin", "end", "deviation"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.curve)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {len(self):,} of {counted(len(self.first) - 1, 'curves')}>"

    def locate(self, curve: npt.ArrayLike, u: npt.ArrayLike) -> tuple[IntArray, Float64Array]:
        """Return the piece that a place on a curve is on, and the place on that piece; see `Curves.locate`."""
        number, at = np.broadcast_arrays(*as_places("curve", curve, len(self.first) - 1, "u", u))
        # Find the last piece that begins at or before the unit. The last unit of a curve includes its end.
        unit = np.minimum((at * UNITS).astype(np.int64), UNITS - 1)
        piece = np.searchsorted(self._begins, number * UNITS + unit, side="right") - 1
        begin, end = self.begin[piece].astype(np.float64), self.end[piece].astype(np.float64)
        return piece, np.asarray((at - begin) / (end - begin))

    @computed_once
    def _begins(self) -> IntArray:
        """Where each piece begins, in units of 1/UNITS, counted over all curves."""
        units = (self.begin.astype(np.float64) * UNITS).astype(np.int64)
        return np.asarray(self.curve * UNITS + units)

    def parameter(self, piece: npt.ArrayLike, s: npt.ArrayLike) -> tuple[IntArray, FloatArray]:
        """Return the curve of a piece, and the parameter of a place on that piece; see `Curves.parameter`."""
        number, at = np.broadcast_arrays(*as_places("piece", piece, len(self), "s", s))
        begin, end = self.begin[number], self.end[number]
        u = begin + at * (end.astype(np.float64) - begin)
        return self.curve[number], np.clip(u.astype(np.float32), begin, end)

    def with_attributes(self, attributes: Mapping[str, AnyArray], end_attributes: Mapping[str, AnyArray]) -> Lines:
        """Return `lines` with the attributes of the curves; see `Curves.as_lines`."""
        u = np.stack([self.begin, self.end], axis=1)
        return replace(
            self.lines,
            attributes={name: values[self.curve] for name, values in attributes.items()},
            end_attributes={name: _between(values[self.curve], u) for name, values in end_attributes.items()},
        )


def _between(ends: AnyArray, u: FloatArray) -> AnyArray:
    """Interpolate values at both ends of curves, (n, 2, …), at the parameters `u`, (n, 2)."""
    u = u.reshape(*u.shape, *[1] * (ends.ndim - 2))
    first, last = ends[:, :1], ends[:, 1:]
    if ends.dtype.kind != "f":
        return np.where(u < 0.5, first, last)
    with np.errstate(invalid="ignore"):  # where one end is infinite, or both are
        inner = ((1 - u.astype(np.float64)) * first + u * last.astype(np.float64)).astype(ends.dtype)
    # Take the value of the nearer end where one end is infinite or NaN.
    is_finite = np.isfinite(first) & np.isfinite(last)
    inner = np.where(is_finite, inner, np.where(u < 0.5, first, last))
    # Keep the exact values at the ends of curves, so that neighbours agree.
    return np.where(u <= 0, first, np.where(u >= 1, last, inner))


def as_places(
    what: str, numbers: npt.ArrayLike, n: int, name: str, positions: npt.ArrayLike
) -> tuple[IntArray, Float64Array]:
    """Check the numbers of curves or pieces, and positions from 0 to 1 on them."""
    number, at = np.asarray(numbers), np.asarray(positions)
    if number.size == 0:
        number = number.astype(np.int64)
    if number.dtype.kind not in "iu" or (number.size and not 0 <= number.min() <= number.max() < n):
        most = f"0 to {n - 1}" if n else "none, because there are no curves"
        raise InputError(f"{what} holds {_extremes(number)}; expected whole numbers: {most}")
    if at.dtype.kind not in "fiu" or (at.size and not (at.min() >= 0 and at.max() <= 1)):
        raise InputError(f"{name} holds {_extremes(at)}; expected numbers from 0 to 1")
    try:
        np.broadcast_shapes(number.shape, at.shape)
    except ValueError:
        raise InputError(f"{what} has shape {number.shape} and {name} {at.shape}; expected the same shape") from None
    return number.astype(np.int64, copy=False), at.astype(np.float64, copy=False)


def _extremes(values: npt.NDArray[Any]) -> str:
    """Describe numbers in an error message by the least and the greatest."""
    if values.dtype.kind not in "fiu":
        return kind_of(values)
    return str(values) if values.ndim == 0 else f"numbers from {values.min()} to {values.max()}"


def cut_curves(
    control: FloatArray,
    radius: FloatArray | None,
    strands: IntArray,
    tolerance: float | None,
    facts: Mapping[str, Any],
) -> Pieces:
    """Cut curves into round cones: (n, 4, 3) control points and (n, 4) radii of Bezier curves.

    `facts` has the upward axis, the unit and the metadata of `Lines`.
    """
    n = len(control)
    batches = [slice(start, start + BATCH) for start in range(0, max(n, 1), BATCH)]
    parts = []
    for rows in batches:
        radii = np.zeros((len(control[rows]), 4)) if radius is None else radius[rows].astype(np.float64)
        chords = _cut_batch(control[rows].astype(np.float64), radii, tolerance)
        parts.append(chords._replace(curve=chords.curve + rows.start))
    curve, begin, end, ends, off, reached = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    if not reached.all():
        coarse = np.zeros(n, np.bool_)
        coarse[curve[~reached]] = True
        warn_caller(
            f"{int(coarse.sum())} of {n} curves ({list_rows(coarse)}) are off by up to {off[~reached].max():.2g}, more "
            f"than their tolerance, where they are cut into parts of 1/{MAX_PIECES}; give a larger tolerance, or cut "
            "these curves first",
            PrecisionWarning,
        )
    lines = Lines(
        own(ends[..., :3].astype(np.float32)),
        own(strands[curve]),
        None if radius is None else own(np.maximum(ends[..., 3], 0).astype(np.float32)),
        **facts,
    )
    first = np.concatenate([[0], np.cumsum(np.bincount(curve, minlength=n))])
    units = [(column / UNITS).astype(np.float32) for column in (begin, end)]
    return Pieces(lines, own(curve), own(first), own(units[0]), own(units[1]), own(off))


def _cut_batch(control: Float64Array, radii: Float64Array, tolerance: float | None) -> Chords:
    """Cut a few curves; see `bezier.cut`."""
    most = np.maximum(largest(radii), 0)
    # The balls around one point fill the largest of them: one piece of that radius.
    is_point = (control == control[:, :1]).all(axis=(1, 2))
    radii = np.where(is_point[:, None], most[:, None], radii)
    side = (control.max(axis=1) - control.min(axis=1)).max(axis=1, initial=0)
    of_box = OF_BOX * (side + 2 * most)
    rounding = ROUNDING * np.abs(control).max(axis=(1, 2), initial=0)

    def allowed(curve: IntArray, part: Float64Array) -> Float64Array:
        if tolerance is not None:
            return np.full(len(curve), tolerance)
        r0, r1, r2, r3 = part[..., 3].T
        local = np.maximum(np.minimum(np.minimum(r0, r1), np.minimum(r2, r3)), LEAST_LOCAL * most[curve])
        of_radius = np.where(most[curve] > 0, OF_RADIUS * local, np.inf)
        return np.asarray(np.maximum(np.minimum(of_box[curve], of_radius), rounding[curve]))

    return cut(np.concatenate([control, radii[..., None]], axis=2), allowed)
