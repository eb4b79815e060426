"""Checks of boxes, and their conversion to flat float64 corners less the offset of their scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray, is_on_device, to_float64
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...geometry.hit_places import Float64Array
from ...geometry.offsets import NO_OFFSET
from ..rays import warn_of_coarse
from .points import is_to_surface


@dataclass(frozen=True)
class Regions:
    """Checked boxes: corners (n, 3) less the offset, and whether radii count."""

    low: Float64Array
    high: Float64Array
    surface: bool

    def __len__(self) -> int:
        return len(self.low)

    def some(self, boxes: IntArray) -> Regions:
        """Return some of the boxes."""
        return Regions(self.low[boxes], self.high[boxes], self.surface)

    @classmethod
    def of(cls, geometry: AnyGeometry, low: npt.ArrayLike, high: npt.ArrayLike, to: str | None) -> Regions:
        """Check boxes, and subtract the offset of the geometry."""
        surface = is_to_surface(geometry, to)
        corners = [_corners(values, name) for name, values in (("low", low), ("high", high))]
        try:
            shape = np.broadcast_shapes(*(array.shape for array in corners))
        except ValueError:
            shapes = f"low {corners[0].shape} and high {corners[1].shape}"
            raise InputError(
                f"{shapes} do not match; expected a high corner for each low one, or one for all"
            ) from None
        lows, highs = (np.broadcast_to(array, shape).reshape(-1, 3) for array in corners)
        if (wrong := ~(lows <= highs) | (lows == np.inf) | (highs == -np.inf)).any():
            box, axis = map(int, np.argwhere(wrong)[0])
            which = f"box {box} of {len(lows)}" if len(lows) > 1 else "the box"
            raise InputError(
                f"{which} reaches from {lows[box, axis]:g} to {highs[box, axis]:g} along {'xyz'[axis]}; expected "
                "low <= high, and no NaN"
            )
        if geometry.offset != NO_OFFSET:
            lows, highs = lows - np.array(geometry.offset), highs - np.array(geometry.offset)
            warn_of_coarse("low corners", low, lows, geometry.offset, geometry.bounds)
            warn_of_coarse("high corners", high, highs, geometry.offset, geometry.bounds)
        return cls(np.ascontiguousarray(lows), np.ascontiguousarray(highs), surface)


def _corners(values: npt.ArrayLike, name: str) -> Float64Array:
    """Return corners, (…, 3); a number is the corner of that number on each axis."""
    if is_on_device(values):
        raise InputError(f"{name} is in the memory of a GPU, and in_box runs on the CPU; pass a NumPy array")
    array = to_float64(values, name)
    if array.ndim == 0:
        return np.full(3, array)
    if array.shape == (0,):
        return array.reshape(0, 3)
    if array.shape[-1] != 3:
        raise InputError(f"{name} has shape {array.shape}; expected (…, 3): x y z of a corner of each box")
    return array
