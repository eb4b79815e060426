"""The view of a scene along an axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import choice
from ..geometry.hit_places import Float64Array
from ..geometry.lines import AXES

#: The axis of view; None is the one on which the scene is shortest.
AxisOption: TypeAlias = Literal["x", "y", "z"] | None


@dataclass(frozen=True)
class Projection:
    """A view along an axis; of the other two, the first goes to the right and the second upwards.

    Examples
    --------
    >>> Projection(1).names
    ('x', 'z')
    """

    axis: int

    @property
    def plane(self) -> tuple[int, int]:
        """The axes to the right and upwards."""
        across, upwards = (axis for axis in range(3) if axis != self.axis)
        return across, upwards

    @property
    def names(self) -> tuple[str, str]:
        """Their names."""
        across, upwards = self.plane
        return AXES[across], AXES[upwards]

    def points(self, points: npt.NDArray[np.floating]) -> Float64Array:
        """Return points (…, 3) in the plane of the picture, (…, 2)."""
        return np.asarray(points, np.float64)[..., list(self.plane)]

    def rectangles(self, boxes: Float64Array) -> Float64Array:
        """Return the corners of boxes (n, 2, 3) in the plane of the picture, (n, 4, 2), counterclockwise."""
        low, high = self.points(boxes[:, 0]), self.points(boxes[:, 1])
        x0, y0, x1, y1 = low[:, 0], low[:, 1], high[:, 0], high[:, 1]
        return np.stack([x0, y0, x1, y0, x1, y1, x0, y1], axis=1).reshape(-1, 4, 2)


def projection_of(root: Float64Array, axis: AxisOption = None) -> Projection:
    """Return the view along an axis, by default the one on which the root's box (2, 3) is shortest; of equal ones z.

    Examples
    --------
    >>> projection_of(np.array([[0.0, 0, 0], [3, 1, 2]])), projection_of(np.array([[0.0, 0, 0], [3, 1, 2]]), "x").axis
    (Projection(axis=1), 0)
    """
    if axis is not None:
        return Projection(AXES.index(choice("axis", axis, tuple(AXES))))
    sides = root[1] - root[0]
    return Projection(2 - int(sides[::-1].argmin()))
