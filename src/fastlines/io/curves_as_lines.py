"""Converts curves to lines, for formats without curves: the lines are the pieces of the curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import AnyArray, FloatArray
from ..geometry.curves import Curves
from ..geometry.lines import Lines


def curves_as_lines(curves: Curves) -> Lines:
    """Return the pieces of curves as lines with the attributes of the curves.

    Values at both ends of a curve are interpolated linearly in its parameter. Integers and booleans are those of the
    nearer end.

    Examples
    --------
    >>> ends = {"heat": np.array([[0.0, 1.0]])}
    >>> curves = Curves.from_bezier([[[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 0, 0]]], tolerance=0.2, end_attributes=ends)
    >>> curves_as_lines(curves).end_attributes["heat"].tolist()
    [[0.0, 0.5], [0.5, 1.0]]
    """
    pieces = curves.pieces
    u = np.stack([pieces.begin, pieces.end], axis=1)
    return replace(
        pieces.lines,
        attributes={name: values[pieces.curve] for name, values in curves.attributes.items()},
        end_attributes={name: _between(values[pieces.curve], u) for name, values in curves.end_attributes.items()},
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
