"""The points of strands: lines as polylines, one after the other, and where each begins."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..arrays import AnyArray, FloatArray, IntArray
from ..support.computed_once import computed_once
from ..support.immutable import own
from .axis_geometry import AxisGeometry
from .offsets import NO_OFFSET


class StrandPoints(AxisGeometry):
    """Segments whose strands are polylines."""

    # A subclass has it as a field.
    segments: FloatArray

    @computed_once
    def offsets(self) -> IntArray:
        """The first of the `points` of each strand, and the number of points, (n_polylines + 1,) int64.

        A strand that forks or has gaps is several polylines, and a segment without a strand is one.
        """
        first = np.append(np.flatnonzero(self.begins()), len(self))
        return np.asarray(own(first + np.arange(len(first))))

    @computed_once
    def points(self) -> AnyArray:
        """The points of all strands, one strand after the other, (m, 3) float32; float64 if the lines have an `offset`.

        The offset is added to them. A strand of one point, which is a segment of length zero, has it twice.

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[5, 5, 5], [6, 6, 6]]])
        >>> len(lines.points), lines.offsets
        (5, array([0, 3, 5]))
        """
        points = self.at_points(self.segments)
        return np.asarray(own(points if self.offset == NO_OFFSET else points + np.array(self.offset)))

    def at_points(self, values: AnyArray) -> AnyArray:
        """Return values at both ends of segments, (n, 2, …), as values of `points`, (m, …).

        Where they differ on both sides of a point, the value is that of the segment that begins there.

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = fl.Lines.from_points(np.eye(3), [3], attributes={"fa": np.array([0.1, 0.2, 0.3])})
        >>> lines.at_points(lines.end_attributes["fa"])
        array([0.1, 0.2, 0.3])
        """
        is_last = np.zeros(self.offsets[-1], np.int64)
        is_last[self.offsets[1:] - 1] = 1
        return np.asarray(values[np.arange(len(is_last)) - np.cumsum(is_last), is_last])

    def to_strands(self) -> list[AnyArray]:
        """Return the points of each strand, (m, 3) arrays that share the memory of `points`: `from_strands` backwards.

        Examples
        --------
        >>> import fastlines as fl
        >>> fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0]]]).to_strands()
        [array([[0., 0., 0.],
               [1., 0., 0.]], dtype=float32)]
        """
        return [self.points[first:end] for first, end in pairwise(self.offsets.tolist())]
