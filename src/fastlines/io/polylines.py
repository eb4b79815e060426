"""Lines as polylines, as writers need them: segments that follow each other along a strand share a point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, FloatArray, IntArray
from ..geometry.axis_geometry import AxisGeometry
from ..geometry.lines import Lines


@dataclass(frozen=True)
class Polylines:
    """Points of polylines, one polyline after the other, with what is known of each point and of each polyline.

    Attributes
    ----------
    points : (m, 3) float32, or float64 if the lines have an offset, which is added
    counts : (k,) int64
        How many points each polyline has: 2 or more.
    strand : (k,) int64
        The strand of each polyline; -1 if it is of none. A strand that forks or has gaps is several polylines.
    radius : (m,) float32 or None
    point_attributes : dict of str to (m, …) array
    attributes : dict of str to (k, …) array
        Attributes that are the same all along each polyline.
    lost : list of str
        What differs on both sides of a point, or along a polyline, in words.
    """

    points: AnyArray
    counts: IntArray
    strand: IntArray
    radius: FloatArray | None
    point_attributes: dict[str, AnyArray]
    attributes: dict[str, AnyArray]
    lost: list[str]

    @property
    def offsets(self) -> IntArray:
        """The first point of each polyline, and the number of points, (k + 1,) int64."""
        return np.concatenate([np.zeros(1, np.int64), np.cumsum(self.counts)])


def polylines_of(lines: Lines) -> Polylines:
    """Join segments to polylines where the next one of a strand begins at the very point at which one ends.

    Examples
    --------
    >>> from fastlines.io.polylines import polylines_of
    >>> lines = Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[5, 5, 5], [6, 6, 6]]])
    >>> polylines_of(lines).counts
    array([3, 2])
    """
    first = lines.offsets[:-1] - np.arange(len(lines.offsets) - 1)
    begins = np.zeros(len(lines), np.bool_)
    begins[first] = True
    lost: list[str] = []

    def at_points(name: str, values: AnyArray) -> AnyArray:
        """Take the values at both ends of each segment to points; where they differ, that of the next segment."""
        before, after = values[:-1][~begins[1:], 1], values[1:][~begins[1:], 0]
        if not equal(before, after):
            lost.append(f"{name} on both sides of a point, where segments of a strand differ")
        return lines.at_points(values)

    radius = None if lines.radius is None else at_points("radius", lines.end_radii)
    points = {name: at_points(repr(name), values) for name, values in lines.end_attributes.items()}
    attributes = attributes_of_runs(lines, begins, lost)
    return Polylines(lines.points, np.diff(lines.offsets), lines.strands[first], radius, points, attributes, lost)


def attributes_of_runs(part: AxisGeometry, begins: npt.NDArray[np.bool_], lost: list[str]) -> dict[str, AnyArray]:
    """Return the attributes, without those at ends, that are equal all along each run; record the others in `lost`."""
    first, run = np.flatnonzero(begins), np.cumsum(begins) - 1
    row = part.place_words[1]
    kept = {}
    for name, values in part.attributes.items():
        if name in part.end_attributes:
            continue
        if equal(values, values[first][run]):
            kept[name] = values[first]
        else:
            lost.append(f"{name!r}, which differs from {row} to {row}")
    return kept


def equal(left: AnyArray, right: AnyArray) -> bool:
    """Return whether values are the same; NaN equals NaN."""
    return np.array_equal(left, right, equal_nan=left.dtype.kind in "fc")
