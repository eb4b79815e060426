"""The default camera: how to look at lines when no direction is given.

What is *up*: the axis that the format of the file tells (`Lines.up`), which trees and their files keep. Where none
does, what stands on the ground y = 0 or above it has y up, like most models; what lies around the coordinate origin has
z up, like most measurements. Flat lines, a map for example, are looked at from above.

The camera then looks along the shorter side, so that the longer one is seen, a little from above and turned towards the
*front*: the end that the lines lean away from, as hair leans away from the face.
"""

from __future__ import annotations

import numpy as np

from ..camera import Camera, Vector
from ..lines import AXES, Lines

#: An extent that is this share of the largest is none.
FLAT = 1e-3
#: Turned so far to the front and tilted so far from above, as slopes.
TURN, TILT = 0.5, 0.22


def default_view(lines: Lines) -> tuple[Vector, Vector]:
    """Choose where to look and what is up.

    Parameters
    ----------
    lines : Lines

    Returns
    -------
    direction, up : tuple of three floats
        For `Camera.framing`.

    Examples
    --------
    >>> default_view(Lines.from_segments([[[0, 0, 0], [3, 2, 0]]]))  # flat: from above
    ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
    """
    axes = np.eye(3)
    if len(lines) == 0:
        return _tuple(-axes[2]), _tuple(axes[1])
    low, high = lines.bounds.astype(np.float64)
    extent = high - low
    flat = int(extent[::-1].argmin())
    flat = 2 - flat
    if extent[flat] <= FLAT * extent.max():
        return _tuple(-axes[flat]), _tuple(axes[2 if flat == 1 else 1])

    stands = low[1] >= -0.1 * extent[1]
    up = AXES.index(lines.up or ("y" if stands else "z"))
    # Of two equal sides look along z, as in most pictures.
    short, long = sorted((axis for axis in (2, 1, 0) if axis != up), key=lambda axis: extent[axis])
    lean = lines.segments.mean(axis=(0, 1), dtype=np.float64)[long] - (low + high)[long] / 2
    front = -1.0 if lean > 0 else 1.0
    return _tuple(-axes[short] - TURN * front * axes[long] - TILT * axes[up]), _tuple(axes[up])


def default_camera(
    lines: Lines,
    *,
    direction: Vector | None = None,
    up: Vector | None = None,
    fov_degrees: float = 30.0,
    aspect: float = 1.0,
) -> Camera:
    """Frame lines; what is not given is chosen by `default_view`."""
    default_direction, default_up = default_view(lines)
    return Camera.framing(
        lines, direction or default_direction, up or default_up, fov_degrees=fov_degrees, aspect=aspect
    )


def _tuple(vector: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Vector:
    x, y, z = vector.tolist()
    # No negative zeros: they look odd.
    return x + 0.0, y + 0.0, z + 0.0
