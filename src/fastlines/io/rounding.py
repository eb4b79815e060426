"""What float32 loses of points that come in parts."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import COARSE, COORDINATE_LIMIT, FloatArray, warn_of_loss
from ..geometry.offsets import NO_OFFSET, Offset
from ..support.immutable import own


class Rounding:
    """Compares points with what float32 makes of them, and warns at the end, as `warn_of_rounding` does of all at once.

    Examples
    --------
    >>> rounding = Rounding()
    >>> rounding.to_float32(np.array([[0.5, 0.25, 4]])), rounding.warn()
    (array([[0.5 , 0.25, 4.  ]], dtype=float32), None)
    """

    def __init__(self) -> None:
        self._low, self._high = np.full(3, np.inf), np.full(3, -np.inf)
        self._lost = 0.0

    def to_float32(self, points: npt.NDArray[Any], offset: Offset = NO_OFFSET) -> FloatArray:
        """Return points (n, 3), less an offset in float64, in float32."""
        if offset != NO_OFFSET:
            points = points - np.array(offset)
        with np.errstate(over="ignore"):  # infinite coordinates are reported with their rows
            rounded = points.astype(np.float32, copy=False)
        if rounded is points or not len(points):
            return rounded
        rounded = own(rounded)
        low, high, kept = *_extremes(points), rounded
        if not (low.min() >= -COORDINATE_LIMIT and high.max() <= COORDINATE_LIMIT):
            good = np.abs(rounded).max(axis=1) <= COORDINATE_LIMIT
            if not good.any():
                return rounded
            points, kept = points[good], rounded[good]
            low, high = _extremes(points)
        self._low, self._high = np.minimum(self._low, low), np.maximum(self._high, high)
        # Compare the points only if they are so far from zero, for their size, that it can matter.
        if not max(-low.min(), high.max()) * 2.0**-24 <= (high - low).max() * COARSE:
            self._lost = max(self._lost, float(np.abs(points.astype(np.float64) - kept).max()))
        return rounded

    def warn(self) -> None:
        """Warn if coordinates were rounded noticeably."""
        if (self._low <= self._high).all():
            far = max(abs(float(self._low.min())), abs(float(self._high.max())))
            warn_of_loss(self._lost, far, float((self._high - self._low).max()))


def _extremes(points: npt.NDArray[Any]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the lowest and the highest corner of points; NaN where one is."""
    # Reduce one axis after the other, which is faster.
    low, high = ([reduce(points[:, axis]) for axis in range(3)] for reduce in (np.min, np.max))
    return np.array(low, np.float64), np.array(high, np.float64)
