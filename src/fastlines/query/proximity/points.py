"""Checks of points, and their conversion to flat float64 arrays less the offset of their scene."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from ...arrays import FLOAT32_MAX, INVALID, FloatArray, IntArray, choice, is_on_device, to_float64
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...geometry.hit_places import Float64Array
from ...geometry.offsets import NO_OFFSET
from ..ignore import Ignored, ignored_of
from ..rays import RADIUS_LIMIT, limits_of, scene_bounds, warn_of_coarse
from ..row_checks import invalid_rows, one_or_each
from .point_arguments import PointArguments

#: What the distance to a thick line may be to.
TO = ("axis", "surface")


@dataclass(frozen=True, eq=False)
class PointBatch:
    """Checked points. Those that were `skipped` are not among them; `shape` is the shape of the answer."""

    shape: tuple[int, ...]
    #: (n, 3), less the offset.
    points: Float64Array
    #: How far answers may be away, (n,) or (1,).
    radius: FloatArray
    #: Whether distances are to the surface of what has a radius, not to its axis.
    surface: bool
    #: Invalid points, counted in the flattened input.
    skipped: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    #: The positions in the flattened input if some were skipped.
    rows: IntArray | None = None
    #: What each point leaves out.
    ignored: tuple[Ignored, ...] = ()
    #: The parts of a `Geometry` that the points see; None for all.
    parts: tuple[int, ...] | None = None

    def __len__(self) -> int:
        return len(self.points)

    @property
    def n_given(self) -> int:
        """The number of points that were given, skipped ones included."""
        return len(self) + len(self.skipped)

    def row(self, given: IntArray) -> IntArray:
        """Return the rows of points by their positions in the flattened input; they were not skipped."""
        return given if self.rows is None else np.searchsorted(self.rows, given)

    def radius_of(self, rows: IntArray) -> FloatArray:
        """Return the radius of each of some points."""
        return np.broadcast_to(self.radius, len(rows)) if len(self.radius) == 1 else self.radius[rows]

    def some(self, rows: IntArray) -> PointBatch:
        """Return a batch of the points in these rows."""
        radius = self.radius if len(self.radius) == 1 else self.radius[rows]
        ignored = tuple(each.some(rows) for each in self.ignored)
        return PointBatch(rows.shape, self.points[rows], radius, self.surface, ignored=ignored, parts=self.parts)


def is_to_surface(geometry: AnyGeometry, to: str | None) -> bool:
    """Check the option `to`, and return whether distances are to surfaces, which lines without a radius do not have."""
    return (to is None or choice("to", to, TO) == "surface") and geometry.max_radius > 0


def check_points(geometry: AnyGeometry, box: FloatArray, given: PointArguments) -> PointBatch:
    """Check points for geometry in this box; of lines it holds the axes.

    Raises
    ------
    InputError
        If a point is invalid, and the message lists the rows.
    """
    choice("invalid", given.invalid, INVALID)
    surface = is_to_surface(geometry, given.to)
    parts = None if given.parts is None else geometry.check_parts(given.parts)
    bounds = scene_bounds(geometry, box)
    points = _less_offset(_vectors(given.points), given.points, geometry, bounds)
    shape, name = points.shape[:-1], given.radius_name
    points = points.reshape(-1, 3)
    radius = one_or_each(name, given.radius, shape, "points")
    ignored = ignored_of(geometry, shape, given.ignore, given.ignore_strands, "points")
    low, high, largest = limits_of(bounds)
    largest = largest if len(geometry) else FLOAT32_MAX
    fits = (radius >= 0) & (radius <= (largest if name == "radius" else np.inf))
    points.flags.writeable = False
    batch = PointBatch(shape, points, radius, surface, ignored=ignored, parts=parts)
    # Mostly the extremes show that all points are valid. NaN propagates to both.
    farthest = float(max(-points.min(), points.max())) if len(points) else 0.0
    if fits.all() and 2 * (farthest + max(map(abs, (*low, *high)))) <= largest:
        return batch
    with np.errstate(invalid="ignore", over="ignore"):
        to_corner = np.maximum(np.abs(points - low), np.abs(points - high))
        is_far = ~(np.sqrt((to_corner**2).sum(axis=1)) <= largest)
    limit = f"{largest:g}" + (f" ({RADIUS_LIMIT:g} times the scene's size)" if len(geometry) else "")
    faults = {
        "hold NaN or Inf": ~np.isfinite(points).all(axis=1),
        f"are farther from the scene than {limit}": is_far,
        f"have a {name} that is not a number from 0 {f'to {limit}' if name == 'radius' else 'up'}": ~fits,
    }
    skipped = invalid_rows(faults, {name: radius}, len(points), "points", given.invalid)
    if not skipped.any():
        return batch
    left = np.flatnonzero(~skipped)
    return replace(batch.some(left), shape=shape, skipped=np.flatnonzero(skipped), rows=left)


def _vectors(values: npt.ArrayLike) -> Float64Array:
    """Return points as a new array of float64."""
    if is_on_device(values):
        raise InputError(
            "points are in the memory of a GPU, and queries about points run on the CPU; pass them as NumPy arrays"
        )
    array = to_float64(values, "points").copy()
    if array.shape == (0,):
        return array.reshape(0, 3)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise InputError(f"points have shape {array.shape}; expected (…, 3): x y z of each point")
    return array


def _less_offset(points: Float64Array, given: npt.ArrayLike, geometry: AnyGeometry, bounds: FloatArray) -> Float64Array:
    """Return points less the offset of their scene, in float64; float32 that is too coarse for that warns."""
    if geometry.offset == NO_OFFSET:
        return points
    with np.errstate(invalid="ignore", over="ignore"):
        less = points - np.array(geometry.offset)
    warn_of_coarse("points", given, less, geometry.offset, bounds)
    return np.asarray(less)
