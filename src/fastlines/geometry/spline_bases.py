"""Cubic bases: which points of a strand make each of its curves, and the Bezier control points of that curve.

A strand of points has one curve for each *span* of four points w₀ … w₃, which begins `step` points after the span
before it. With wrap="periodic" the spans go round. With "pinned" there is a phantom point 2·P₀ − P₁ in front of a
strand and one behind it, so that its curves begin at its first point and end at its last. USD's BasisCurves do the
same.

| basis         | step | Bezier control points                                                            |
|---------------|------|----------------------------------------------------------------------------------|
| "bezier"      | 3    | w₀, w₁, w₂, w₃                                                                   |
| "bspline"     | 1    | (w₀ + 4w₁ + w₂)/6, (2w₁ + w₂)/3, (w₁ + 2w₂)/3, (w₁ + 4w₂ + w₃)/6  (uniform knots) |
| "catmull-rom" | 1    | w₁, w₁ + (w₂ − w₀)/6, w₂ − (w₃ − w₁)/6, w₂  (uniform knots)                       |
| "hermite"     | 1    | w₁, w₁ + m₁/3, w₂ − m₂/3, w₂, with the tangents m; w₀ = w₁ and w₃ = w₂           |

Curves that follow one another get the same sum in the same order where they meet, so they share that point bit for bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, choice, list_rows
from ..errors import InputError
from .bezier import Float64Array

BASES = ("bezier", "bspline", "catmull-rom", "hermite")
WRAPS = ("nonperiodic", "periodic", "pinned")


@dataclass(frozen=True, eq=False)
class Spans:
    """The points of each curve of some strands.

    Attributes
    ----------
    basis : str
        One of `BASES`.
    points : (n, 4) int64
        The points w₀ … w₃ of each curve, as positions among all points.
    strands : (n,) int64
        The strand of each curve.
    begins, ends : (n,) bool
        Whether w₀ or w₃ is a phantom point; `points` then holds the point next to it.
    """

    basis: str
    points: IntArray
    strands: IntArray
    begins: npt.NDArray[np.bool_]
    ends: npt.NDArray[np.bool_]

    def bezier(self, values: Float64Array, tangents: Float64Array | None = None) -> Float64Array:
        """Return the Bezier coefficients of each curve, (n, 4, …), of values at the points, (m, …).

        Values of a Hermite curve that have no tangents are linear from end to end.
        """
        w = values[self.points]
        if self.basis == "bezier":
            return w
        w[self.begins, 0] = 2 * w[self.begins, 1] - w[self.begins, 2]
        w[self.ends, 3] = 2 * w[self.ends, 2] - w[self.ends, 1]
        w0, w1, w2, w3 = np.moveaxis(w, 1, 0)
        if self.basis == "bspline":
            made = [(w0 + 4 * w1 + w2) / 6, (2 * w1 + w2) / 3, (w1 + 2 * w2) / 3, (w1 + 4 * w2 + w3) / 6]
            # A pinned strand begins and ends at its points exactly.
            made[0][self.begins], made[3][self.ends] = w1[self.begins], w2[self.ends]
        elif self.basis == "catmull-rom":
            made = [w1, w1 + (w2 - w0) / 6, w2 - (w3 - w1) / 6, w2]
        elif tangents is None:
            made = [w1, (2 * w1 + w2) / 3, (w1 + 2 * w2) / 3, w2]
        else:
            made = [w1, w1 + tangents[self.points[:, 1]] / 3, w2 - tangents[self.points[:, 2]] / 3, w2]
        return np.stack(made, axis=1)

    def at_ends(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the values at both ends of each curve, (n, 2, …), of values at the points, (m, …).

        Floating-point values of a B-spline are the weighted mean that is the value of the curve. Values of other types
        have no mean: they are those of the points w₁ and w₂.
        """
        if self.basis == "bspline" and values.dtype.kind == "f":
            return self.bezier(values.astype(np.float64))[:, [0, 3]].astype(values.dtype)
        return values[self.points[:, [0, 3] if self.basis == "bezier" else [1, 2]]]


def smallest(basis: str, wrap: str) -> tuple[int, int]:
    """Return how many points the shortest strand has, and how many each further curve takes."""
    choice("basis", basis, BASES)
    choice("wrap", wrap, WRAPS)
    step = 3 if basis == "bezier" else 1
    if wrap == "periodic":
        return step, step
    return (2 if basis == "hermite" or _moves(basis, wrap) else 4), step


def _moves(basis: str, wrap: str) -> bool:
    """Return whether pinning adds phantom points; other curves begin and end at their points anyway."""
    return wrap == "pinned" and basis in ("bspline", "catmull-rom")


def find_spans(counts: IntArray, basis: str, wrap: str) -> Spans:
    """Return the points of each curve of strands with `counts` points each; a strand without points has no curve.

    Raises
    ------
    InputError
        If a strand has a number of points that its basis and wrap cannot use.
    """
    fewest, step = smallest(basis, wrap)
    offsets = np.array([0, 0, 1, 1] if basis == "hermite" else [0, 1, 2, 3])
    pinned = _moves(basis, wrap)
    if pinned:
        offsets = offsets - 1
    bad = (counts > 0) & ((counts < fewest) | ((counts - fewest) % step != 0))
    if bad.any():
        numbers = f"{fewest}, {fewest + 3}, {fewest + 6}, …" if step == 3 else f"{fewest} or more"
        raise InputError(
            f"{int(bad.sum())} of {len(counts)} counts do not fit basis={basis!r} and wrap={wrap!r} "
            f"({list_rows(bad)}; the first is {counts[bad][0]}); expected {numbers} points in each strand, or none"
        )
    n_curves = np.where(counts > 0, (counts - fewest) // step + 1, 0)
    strands = np.repeat(np.arange(len(counts)), n_curves)
    start = np.repeat(np.cumsum(counts) - counts, n_curves)
    position = np.arange(len(strands)) - np.repeat(np.cumsum(n_curves) - n_curves, n_curves)
    size = counts[strands][:, None]
    local = position[:, None] * step + offsets
    local = local % np.maximum(size, 1) if wrap == "periodic" else np.clip(local, 0, np.maximum(size - 1, 0))
    begins, ends = pinned & (position == 0), pinned & (position == n_curves[strands] - 1)
    return Spans(basis, start[:, None] + local, strands, begins, ends)
