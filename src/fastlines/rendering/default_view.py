"""The default camera, for lines whose direction of view is not given.

*Up* is the axis that the format of the file gives (`Lines.up`), which trees and their files keep. Without one, lines on
or above the ground y = 0 have y up, like most models. Lines around the coordinate origin have z up, like most
measurements. Flat lines, such as a map, are shown from above.

The camera looks along the shorter side, so that the longer one is visible, a little from above and turned towards the
*front*. The front is the end from which the lines lean away, as hair leans away from the face. Five shapes differ:

- *Flat* lines are shown square to their plane.
- What would be seen *end on*, such as one line from corner to corner, is turned to the other side.
- A *slab*, such as a mohawk, is shown from its side, where nothing hides anything.
- A *cube* is shown corner on, so that three of its faces are visible.
- What is *low*, such as a plain or a spreading tree, is shown from higher above.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..arrays import box_of, number
from ..camera import Camera, Vector
from ..geometry.any_geometry import AnyGeometry
from ..geometry.lines import AXES
from ..geometry.offsets import NO_OFFSET
from .shading.own_frame import moved

#: Lines are flat if an extent is at most this fraction of the largest.
FLAT = 1e-3
#: A slab is thinner than this fraction of its length, and what is low lower than this fraction of its sides.
SLAB, LOW = 0.4, 0.6
#: The extents of a cube are at least this fraction of the largest.
CUBE = 0.9
#: The turn towards the front and the tilt from above, as slopes: of most lines, of a cube, and the tilt of what is low.
TURN, TILT = 0.5, 0.22
CUBE_TURN, CUBE_TILT = 0.7, 0.45
LOW_TILT = 0.6
#: Points are seen end on if this fraction of their variance, at least, is along the view. About how many are looked at.
END_ON, SOME = 0.8, 4096
#: The vertical field of view of a camera.
FOV_DEGREES = 30.0
#: The formats of pictures, as the longer side through the shorter one.
ASPECT_RATIOS = (1, 4 / 3, 3 / 2, 16 / 9)


def default_view(geometry: AnyGeometry) -> tuple[Vector, Vector]:
    """Choose the direction of view and the upward direction, for `Camera.framing`.

    Examples
    --------
    >>> import fastlines as fl
    >>> default_view(fl.Lines.from_segments([[[0, 0, 0], [3, 2, 0]]]))  # flat: from above
    ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
    """
    axes = np.eye(3)
    points, _ = geometry.span()
    if len(points) == 0:
        return _tuple(-axes[2]), _tuple(axes[1])
    low, high = box_of(points).astype(np.float64)
    extent = high - low
    flat = 2 - int(extent[::-1].argmin())
    if extent[flat] <= FLAT * extent.max():
        return _tuple(-axes[flat]), _tuple(axes[2 if flat == 1 else 1])

    stands = low[1] >= -0.1 * extent[1]
    up = AXES.index(geometry.up or ("y" if stands else "z"))
    # Of two equal sides look along z, as in most pictures.
    short, long = sorted((axis for axis in (2, 1, 0) if axis != up), key=lambda axis: extent[axis])
    lean = points[:, long].mean(dtype=np.float64) - (low + high)[long] / 2
    front = -1.0 if lean > 0 else 1.0
    turn, tilt = _slopes(extent[up], extent[short], extent[long])
    views = [-axes[short] - turn * side * axes[long] - tilt * axes[up] for side in (front, -front)]
    return _tuple(views[is_end_on(points, views[0])]), _tuple(axes[up])


def is_end_on(points: npt.NDArray[np.floating], direction: npt.NDArray[np.float64]) -> bool:
    """Return whether points are spread mostly along a direction, so that hardly anything is visible from there.

    Examples
    --------
    >>> line = np.float32([[0, 0, 0], [1, 1, 1]])
    >>> is_end_on(line, np.array([1.0, 0.8, 1.0])), is_end_on(line, np.array([-1.0, 0.8, 1.0]))
    (True, False)
    """
    some = points[:: len(points) // SOME + 1].astype(np.float64)
    away = some - some.mean(axis=0)
    along = (away @ direction) ** 2 / (direction @ direction)
    return bool(along.sum() > END_ON * (away**2).sum())


def _slopes(height: float, short: float, long: float) -> tuple[float, float]:
    """Return the turn and the tilt for the extents of the lines."""
    if min(height, short) >= CUBE * max(height, long):
        return CUBE_TURN, CUBE_TILT
    return (0.0 if short < SLAB * long else TURN), (LOW_TILT if height < LOW * short else TILT)


def default_camera(
    geometry: AnyGeometry,
    *,
    direction: Vector | None = None,
    up: Vector | None = None,
    fov_degrees: float = FOV_DEGREES,
    aspect: float = 1.0,
    radius: float = 0.0,
) -> Camera:
    """Return a camera that frames a geometry; `default_view` chooses the directions that are not given.

    The parameters are those of `Camera.framing`. The radius is added to that of the lines.

    Examples
    --------
    >>> import fastlines as fl
    >>> line = fl.lines([[[0, 0, 0], [0, 1, 0]]])
    >>> thin, thick = default_camera(line), default_camera(line, radius=0.5)
    >>> math.dist(thick.origin, thick.target) > math.dist(thin.origin, thin.target)
    True
    """
    default_direction, default_up = default_view(geometry)
    return Camera.framing(
        geometry,
        direction or default_direction,
        up or default_up,
        fov_degrees=fov_degrees,
        aspect=aspect,
        radius=radius,
    )


def turntable_camera(
    geometry: AnyGeometry,
    *,
    direction: Vector | None = None,
    up: Vector | None = None,
    fov_degrees: float = FOV_DEGREES,
    aspect: float = 1.0,
    radius: float = 0.0,
) -> Camera:
    """Return a camera that shows all lines at every angle of a turn; `default_view` chooses what is not given.

    It frames the upright cylinder around the lines. Its target is on the cylinder's axis. The parameters are those of
    `default_camera`.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.lines([[[0, 0, 0], [4, 0, 0]], [[2, -1, -2], [2, 1, 2]]])
    >>> camera = turntable_camera(lines, direction=(0, 0, -1), up=(0, 1, 0))
    >>> [round(x, 6) for x in camera.target]
    [2.0, 0.0, 0.0]
    """
    default_direction, default_up = default_view(geometry)
    direction, up = direction or default_direction, up or default_up
    if geometry.offset != NO_OFFSET:
        near = geometry.without_offset()
        camera = turntable_camera(
            near, direction=direction, up=up, fov_degrees=fov_degrees, aspect=aspect, radius=radius
        )
        return moved(camera, geometry.offset)
    points, radii = (values.astype(np.float64) for values in geometry.span())
    if len(points) == 0:
        return default_camera(geometry, direction=direction, up=up, fov_degrees=fov_degrees, aspect=aspect)
    radii += number("radius", radius, "a number from 0 to 1e38", 0.0, 1e38)
    # Find the cylinder about the upward axis.
    axis = np.asarray(up, np.float64) / math.sqrt(sum(x * x for x in up))
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    height = ((points - centre) * axis).sum(axis=1)
    away = points - centre - height[:, None] * axis
    wide = float((np.sqrt((away**2).sum(axis=1)) + radii).max())
    low, high = float((height - radii).min()), float((height + radii).max())
    # Frame two of its circles.
    one = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    one /= math.sqrt(float((one**2).sum()))
    turns = np.linspace(0, 2 * np.pi, 64, endpoint=False)[:, None]
    circle = wide * (np.cos(turns) * one + np.sin(turns) * np.cross(axis, one))
    rims = np.concatenate([centre + low * axis + circle, centre + high * axis + circle])
    camera = Camera.framing(rims, direction, up, fov_degrees=fov_degrees, aspect=aspect)
    # Move the target along the view to the axis.
    forward, start = camera.axes()[2], np.subtract(camera.origin, centre)
    across = forward - (forward * axis).sum() * axis
    level = float((across**2).sum())
    if level < 1e-12:
        return camera
    distance = -float((start * across).sum()) / level
    x, y, z = (camera.origin + distance * forward).tolist()
    return replace(camera, target=(x, y, z))


@dataclass(frozen=True)
class ViewOptions:
    """How to choose a camera; what is None is chosen to suit the lines.

    With `turns` all lines are visible at every angle of a turn.
    """

    direction: Vector | None = None
    up: Vector | None = None
    fov_degrees: float | None = None
    lens_radius: float | None = None
    focus_distance: float | None = None
    turns: bool = False

    def camera(self, geometry: AnyGeometry, aspect: float = 1.0, radius: float = 0.0) -> Camera:
        """Return a camera that frames a geometry to whose own radius one is added."""
        frame = turntable_camera if self.turns else default_camera
        fov = FOV_DEGREES if self.fov_degrees is None else self.fov_degrees
        camera = frame(geometry, direction=self.direction, up=self.up, fov_degrees=fov, aspect=aspect, radius=radius)
        return replace(camera, lens_radius=self.lens_radius or 0.0, focus_distance=self.focus_distance)


def default_size(
    geometry: AnyGeometry, side: int, *, direction: Vector | None = None, up: Vector | None = None
) -> tuple[int, int]:
    """Return the width and the height of a picture whose aspect ratio is the nearest to that of the lines in view.

    Aspect ratios are 1:1, 4:3, 3:2 and 16:9, upright or across. All pictures have about side² pixels.

    Examples
    --------
    >>> import fastlines as fl
    >>> default_size(fl.Lines.from_segments([[[0, 0, 0], [2, 1, 0]]]), 900)
    (1200, 675)
    """
    points, _ = geometry.span()
    if len(points) == 0:
        return side, side
    pixels, _ = default_camera(geometry, direction=direction, up=up).project(points, 1, 1)
    width, height = np.maximum(np.ptp(pixels, axis=0), 1e-9)
    ratio = abs(np.log(width / height))
    root = min(ASPECT_RATIOS, key=lambda each: abs(np.log(each) - ratio)) ** 0.5
    longer, shorter = round(side * root), round(side / root)
    return (longer, shorter) if width > height else (shorter, longer)


def complete_size(width: int | None, height: int | None, suitable: tuple[int, int]) -> tuple[int, int]:
    """Return the width and the height of a picture; what is not given follows from a suitable size.

    Examples
    --------
    >>> complete_size(None, None, (1200, 900)), complete_size(None, 300, (1200, 900))
    ((1200, 900), (400, 300))
    """
    if width is not None and height is not None:
        return width, height
    if width is not None:
        return width, max(1, round(width * suitable[1] / suitable[0]))
    if height is not None:
        return max(1, round(height * suitable[0] / suitable[1])), height
    return suitable


def _tuple(vector: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Vector:
    x, y, z = vector.tolist()
    # Avoid negative zeros, which look odd.
    return x + 0.0, y + 0.0, z + 0.0
