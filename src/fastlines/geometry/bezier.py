"""Cubic Bezier curves in float64: their points, their largest value, and chords that stay near them.

**How far a chord is off.** Let a curve C, t from 0 to 1, have control points b₀ … b₃ and the chord
c(t) = b₀ + t·(b₃ − b₀). The error of linear interpolation is |C(t) − c(t)| ≤ max |C″| / 8. C″ is linear from
6·(b₀ − 2b₁ + b₂) to 6·(b₁ − 2b₂ + b₃), so

    |C(t) − c(t)| ≤ ¾ · max(|b₀ − 2b₁ + b₂|, |b₁ − 2b₂ + b₃|).

The same holds for the radius r(t). The balls of radius r(t) around C(t) and of the chord's radius around c(t) differ by
at most the sum of both bounds (Hausdorff distance), so the swept curve and the round cone do, too. The bound is for
equal t. So it also says how far the point of the chord is from that of the curve with the same parameter.

**Where the radius passes zero**, it is max(r, 0), and the chord's is linear from max(r₀, 0) to max(r₃, 0). If r₀
and r₃ have different signs, this adds at most |r₀|·|r₃| / (|r₀| + |r₃|): the chord's radius where the line from r₀ to
r₃ is 0.

**Cutting.** The bound falls with the square of the length, so n parts of equal length are allowed for n² ≥ bound /
allowed. Where one half needs longer parts than the other, both are cut on their own: a curve is cut into equal parts or
into its halves (de Casteljau), whichever makes fewer pieces. Where the radius may pass zero, there are only halves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray

Float64Array = npt.NDArray[np.float64]

#: A curve is halved at most so often.
MAX_LEVEL = 12

#: The most pieces of a curve.
MAX_PIECES = 2**MAX_LEVEL

#: Pieces begin and end at multiples of 1/UNITS, which float32 holds.
UNITS = 2**20

#: A derivative that is smaller than this fraction of the control polygon's longest side counts as zero.
NO_DERIVATIVE = 2.0**-40


class CurvePoints(NamedTuple):
    """Points of curves, with their unit tangents, (…, 3), and radii, (…), in float64."""

    points: Float64Array
    tangents: Float64Array
    radius: Float64Array


def evaluate(control: Float64Array, t: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the points of curves (n, 4, d) at t (n,), and the unit vectors along them, both (n, d).

    Where a curve stands still, the vector is the one in which it goes on, or came at its end; NaN if it never moves.
    """
    along = t[:, None, None]
    third = np.diff(control, 3, axis=1)[:, 0]
    longest = np.sqrt((np.diff(control, axis=1) ** 2).sum(axis=-1)).max(axis=1, initial=0)
    quadratic = (1 - along) * control[:, :-1] + along * control[:, 1:]
    second = np.diff(quadratic, 2, axis=1)[:, 0]
    linear = (1 - along) * quadratic[:, :-1] + along * quadratic[:, 1:]
    first = np.diff(linear, axis=1)[:, 0]
    points = ((1 - along) * linear[:, :-1] + along * linear[:, 1:])[:, 0]

    # Take the first derivative that is not zero; the second points backwards at the end.
    direction = third
    for vectors in (np.where(t[:, None] < 1, second, -second), first):
        moves = np.sqrt((vectors**2).sum(axis=-1)) > NO_DERIVATIVE * longest
        direction = np.where(moves[:, None], vectors, direction)
    with np.errstate(invalid="ignore"):
        return points, direction / np.sqrt((direction**2).sum(axis=-1, keepdims=True))


def largest(coefficients: Float64Array) -> Float64Array:
    """Return the largest value of each cubic (n, 4) for t from 0 to 1, (n,)."""
    # Solve a·t² + b·t + c = 0, the derivative, without cancellation.
    d0, d1, d2 = np.diff(coefficients, axis=1).T
    a, b, c = d0 - 2 * d1 + d2, 2 * (d1 - d0), d0
    with np.errstate(divide="ignore", invalid="ignore"):
        q = -(b + np.copysign(np.sqrt(b * b - 4 * a * c), b)) / 2
        roots = np.stack([q / a, c / q], axis=1)
    t = np.clip(np.where(np.isfinite(roots), roots, 0), 0, 1)
    inside = [evaluate(coefficients[..., None], at)[0][:, 0] for at in t.T]
    return np.asarray(np.max([coefficients[:, 0], coefficients[:, 3], *inside], axis=0))


def deviation(control: Float64Array) -> Float64Array:
    """Return how far each curve (n, 4, 4), x y z and radius, is from its chord at most, (n,)."""
    b0, b1, b2, b3 = np.moveaxis(control, 1, 0)
    first, last = b0 - 2 * b1 + b2, b1 - 2 * b2 + b3
    axis = np.sqrt(np.maximum(*(v[:, 0] ** 2 + v[:, 1] ** 2 + v[:, 2] ** 2 for v in (first, last))))
    radius = np.maximum(np.abs(first[:, 3]), np.abs(last[:, 3]))
    r0, r3 = b0[:, 3], b3[:, 3]
    apart = np.abs(r0) + np.abs(r3)
    passing = np.where(r0 * r3 < 0, np.abs(r0 * r3) / np.where(apart > 0, apart, 1), 0)
    return np.asarray(0.75 * (axis + radius) + passing)


def halves(control: Float64Array) -> Float64Array:
    """Return both halves of curves (n, 4, d), one after the other, (2n, 4, d)."""
    b0, b1, b2, b3 = np.moveaxis(control, 1, 0)
    b01, b12, b23 = (b0 + b1) / 2, (b1 + b2) / 2, (b2 + b3) / 2
    b012, b123 = (b01 + b12) / 2, (b12 + b23) / 2
    middle = (b012 + b123) / 2
    both = np.stack([b0, b01, b012, middle, middle, b123, b23, b3], axis=1)
    return both.reshape(-1, 4, control.shape[2])


class Chords(NamedTuple):
    """Chords of curves, in the order of the curves and of their parameter.

    Attributes
    ----------
    curve : (p,) int64
        The curve of each chord.
    begin, end : (p,) int64
        The parameter at both ends, in units of 1/`UNITS`.
    ends : (p, 2, 4) float64
        Both ends of each chord. Chords that follow one another have the same end, bit for bit.
    off : (p,) float64
        How far each chord is from its part of the curve at most.
    reached : (p,) bool
        Whether that is allowed; false only for chords that are too short to be cut again.
    """

    curve: IntArray
    begin: IntArray
    end: IntArray
    ends: Float64Array
    off: Float64Array
    reached: npt.NDArray[np.bool_]


def cut(control: Float64Array, allowed: Callable[[IntArray, Float64Array], Float64Array]) -> Chords:
    """Cut curves (n, 4, 4), x y z and radius, into chords that are off by at most what is allowed.

    Parameters
    ----------
    control : (n, 4, 4) array
        Bezier coefficients.
    allowed : function
        Takes the number and the coefficients of parts of curves, and returns how far each may be from its chord.
    """
    parts = _halve(control, allowed)
    parts[-1] = parts[-1]._replace(n=np.ones_like(parts[-1].n))
    least = parts[-1].n
    for part in reversed(parts[:-1]):
        # Compare equal parts with the best cuts of both halves.
        of_halves = np.full(len(part.n), np.inf)
        of_halves[part.n > 1] = least.reshape(-1, 2).sum(axis=1)
        part.halved[:] = of_halves < part.n
        least = np.minimum(of_halves, part.n)

    chords = []
    used = np.ones(len(control), np.bool_)
    for level, part in enumerate(parts):
        chords.append(_equal_parts(part.some(used & ~part.halved), UNITS >> level))
        used = np.repeat((used & part.halved)[part.n > 1], 2)
    curve, begin, end, ends, off, reached = (np.concatenate(columns) for columns in zip(*chords, strict=True))
    order = np.argsort(curve * UNITS + begin, kind="stable")
    return Chords(curve[order], begin[order], end[order], ends[order], off[order], reached[order])


class _Parts(NamedTuple):
    """Parts of curves, all of the same length.

    Attributes
    ----------
    curve, begin : (n,) int64
        As in `Chords`.
    control : (n, 4, 4) float64
    off, allowed : (n,) float64
        How far a chord of the whole part is off at most, and may be.
    n : (n,) float64
        How many equal parts are allowed; infinite where there are only halves.
    halved : (n,) bool
        Whether its halves make fewer pieces.
    """

    curve: IntArray
    begin: IntArray
    control: Float64Array
    off: Float64Array
    allowed: Float64Array
    n: Float64Array
    halved: npt.NDArray[np.bool_]

    def some(self, which: npt.NDArray[np.bool_]) -> _Parts:
        """Return those that are chosen."""
        curve, begin, control, off, allowed, n, halved = self
        columns = (curve[which], begin[which], control[which], off[which], allowed[which], n[which], halved[which])
        return _Parts(*columns)


def _halve(control: Float64Array, allowed: Callable[[IntArray, Float64Array], Float64Array]) -> list[_Parts]:
    """Halve curves, and again what is off by more than allowed; return the parts of each length."""
    curve, begin = np.arange(len(control)), np.zeros(len(control), np.int64)
    found = []
    for level in range(MAX_LEVEL + 1):
        off, most = deviation(control), allowed(curve, control)
        with np.errstate(divide="ignore"):
            # The ends of equal parts are rounded to units, which makes some longer by 1 in 2^8 at most.
            n = np.ceil(np.sqrt(off / np.where(most > 0, most, np.where(off > 0, 0, 1))) * (1 + 2.0**-8))
        passes = (control[:, :, 3].min(axis=1) < 0) & (control[:, :, 3].max(axis=1) > 0)
        n = np.where(off <= most, 1, np.where(passes, np.inf, np.maximum(n, 2)))
        found.append(_Parts(curve, begin, control, off, most, n, np.zeros(len(n), np.bool_)))
        again = n > 1
        if not again.any():
            break
        curve, control = np.repeat(curve[again], 2), halves(control[again])
        begin = np.repeat(begin[again], 2)
        begin[1::2] += UNITS >> (level + 1)
    return found


def _equal_parts(part: _Parts, length: int) -> Chords:
    """Cut parts of some length into n chords each."""
    n = part.n.astype(np.int64)
    row = np.repeat(np.arange(len(n)), n)
    i = np.arange(len(row)) - np.repeat(np.cumsum(n) - n, n)
    ends = np.empty((len(row), 2, 4))
    at = [(i + k) * length // n[row] for k in (0, 1)]
    for k in (0, 1):
        inner = (at[k] > 0) & (at[k] < length)
        ends[:, k] = part.control[row, np.where(at[k] > 0, 3, 0)]
        ends[inner, k] = evaluate(part.control[row[inner]], at[k][inner] / length)[0]
    off = part.off[row] * ((at[1] - at[0]) / length) ** 2
    begin = part.begin[row]
    return Chords(part.curve[row], begin + at[0], begin + at[1], ends, off, off <= part.allowed[row])
