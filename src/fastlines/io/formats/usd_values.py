"""Values of USD, as arrays; remarks on prims; and which values belong to which segment of a prim's curves."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, IntArray, neighbours
from ...geometry.spline_bases import Spans, find_spans, smallest
from ..source import Source

Float64Array: TypeAlias = npt.NDArray[np.float64]

#: Where values of curves are: one for all, for each curve, for each end of a segment, for each point.
INTERPOLATIONS = ("constant", "uniform", "varying", "vertex")


@dataclass
class Remarks:
    """What is odd about prims, or is left out: the same remark on several prims is made once."""

    source: Source
    paths: dict[str, list[str]] = field(default_factory=dict)

    def add(self, text: str, path: object) -> None:
        """Make a remark on a prim."""
        self.paths.setdefault(text, []).append(str(path))

    def warn(self) -> None:
        """Warn of all remarks."""
        for text, paths in self.paths.items():
            count = f"{len(paths):,} prims, such as {paths[0]}" if len(paths) > 1 else paths[0]
            self.source.warn(f"{text} ({count})")


def numbers(value: Any) -> AnyArray | None:
    """Return a value of USD as an array of real numbers; None if it is something else, or nothing."""
    if value is None or isinstance(value, str):
        return None
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        return None
    return array if array.dtype.kind in "fiub" else None


@dataclass(frozen=True)
class Layout:
    """Which values belong to which segment of the curves of one prim.

    Attributes
    ----------
    strands : (n,) int64
        The curve that each segment is part of.
    spans : Spans or None
        The points of each cubic segment.
    runs : (k,) int64 or None
        How many points each open polyline has, without those that have none. Their points need no indices.
    varying : (n, 2) int64 or None
        The varying values at both ends of each segment; None for open polylines. At the ends of linear segments, they
        are the points.
    sizes : dict of str to int
        How many values there are with each interpolation.
    n_left_out : int
        How many curves have a number of points that does not fit their basis and wrap.
    """

    strands: IntArray
    spans: Spans | None
    runs: IntArray | None
    varying: IntArray | None
    sizes: dict[str, int]
    n_left_out: int

    def control(self, points: AnyArray, tangents: AnyArray | None = None) -> AnyArray:
        """Return the ends of each linear segment, (n, 2, 3), or the Bezier control points, (n, 4, 3)."""
        if self.spans is None:
            return self._varying(points)
        if self.spans.basis != "bezier":
            points = points.astype(np.float64)
        return np.asarray(self.spans.bezier(points, None if tangents is None else tangents.astype(np.float64)))

    def coefficients(self, values: AnyArray, interpolation: str) -> AnyArray:
        """Return scalars as `control` does: (n, 2) of linear segments, or (n, 4)."""
        if self.spans is not None and interpolation == "vertex":
            return np.asarray(self.spans.bezier(values if self.spans.basis == "bezier" else values.astype(np.float64)))
        at_ends = self.at_ends(values, interpolation)
        if self.spans is None:
            return at_ends
        first, last = at_ends.astype(np.float64).T
        return np.stack([first, (2 * first + last) / 3, (first + 2 * last) / 3, last], axis=1)

    def at_ends(self, values: AnyArray, interpolation: str) -> AnyArray:
        """Return the values at both ends of each segment, (n, 2, …)."""
        if interpolation in ("constant", "uniform"):
            row = self.per_segment(values, interpolation)
            return np.stack([row, row], axis=1)
        if interpolation == "varying" or self.spans is None:
            return self._varying(values)
        return np.asarray(self.spans.at_ends(values))

    def _varying(self, values: AnyArray) -> AnyArray:
        """Return varying values at both ends of each segment, as a new array."""
        if self.runs is not None:
            return neighbours(values[: int(self.runs.sum())], self.runs)
        return np.asarray(values[self.varying])

    def per_segment(self, values: AnyArray, interpolation: str) -> AnyArray:
        """Return constant or uniform values for each segment, (n, …)."""
        if interpolation == "constant":
            return np.repeat(values[:1], len(self.strands), axis=0)
        return np.asarray(values[self.strands])

    def interpolation_of(self, n_values: int, stated: str) -> str | None:
        """Return the interpolation of `n_values` values: the stated one, or else the only one that fits."""
        if self.sizes.get(stated) == n_values:
            return stated
        if n_values == 1:
            return "constant"
        fitting = [name for name in INTERPOLATIONS if self.sizes[name] == n_values]
        if self.spans is None and fitting[-2:] == ["varying", "vertex"]:  # which are the same there
            fitting.pop()
        return fitting[0] if len(fitting) == 1 else None


def linear_layout(counts: IntArray, n_curves: int, n_points: int, *, closed: bool) -> Layout:
    """Return the layout of polylines; a lone point joins itself, and closed ones end at their first point."""
    n_segments = np.where(counts > 1, counts if closed else counts - 1, counts)
    strands = np.repeat(np.arange(len(counts)), n_segments)
    sizes = {"constant": 1, "uniform": n_curves, "varying": n_points, "vertex": n_points}
    if not closed:
        return Layout(strands, None, counts[counts > 0], None, sizes, 0)
    position = np.arange(len(strands)) - np.repeat(np.cumsum(n_segments) - n_segments, n_segments)
    start = np.repeat(np.cumsum(counts) - counts, n_segments)
    following = (position + 1) % np.maximum(counts[strands], 1)
    return Layout(strands, None, None, np.stack([start + position, start + following], axis=1), sizes, 0)


def cubic_layout(counts: IntArray, n_curves: int, n_points: int, basis: str, wrap: str) -> Layout:
    """Return the layout of cubic curves, without those whose number of points does not fit."""
    fewest, step = smallest(basis, wrap)
    fits = (counts == 0) | ((counts >= fewest) & ((counts - fewest) % step == 0))
    spans = find_spans(np.where(fits, counts, 0), basis, wrap)
    if not fits.all():
        kept = np.flatnonzero(np.repeat(fits, counts))
        spans = replace(spans, points=kept[spans.points])

    # Each curve has one varying value more than segments, but a closed one, which ends with its first.
    n_segments = np.where(counts > 0, np.maximum(counts - fewest, 0) // step + 1, 0)
    n_varying = n_segments if wrap == "periodic" else n_segments + (counts > 0)
    used = np.where(fits, n_segments, 0)
    position = np.arange(len(spans.strands)) - np.repeat(np.cumsum(used) - used, used)
    start = (np.cumsum(n_varying) - n_varying)[spans.strands]
    following = (position + 1) % np.maximum(n_segments[spans.strands], 1) if wrap == "periodic" else position + 1
    varying = np.stack([start + position, start + following], axis=1)
    sizes = {"constant": 1, "uniform": n_curves, "varying": int(n_varying.sum()), "vertex": n_points}
    return Layout(spans.strands, spans, None, varying, sizes, int((~fits).sum()))
