"""A camera: rays for pictures, a frame around geometry, and the way back from points to pixels.

A point at (x, y, depth) in the camera's axes lies in the picture where |y| ≤ depth·tan(fov/2) and |x| ≤
depth·tan(fov/2)·aspect. `Camera.framing` solves these four inequalities for the camera's position: along a
fixed direction each of them is linear, so only the extreme point for each side of the frame matters.

All of this is of a pinhole. With a lens, the pinhole ray of a point of the picture says where that point is sharp; rays
go there from all points of the lens (Cook, Porter and Carpenter, "Distributed Ray Tracing", 1984).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .arrays import COARSE, AnyArray, FloatArray, check_fields, count, number
from .errors import InputError
from .geometry.any_geometry import AnyGeometry
from .support.vectors import dot, is_point

Vector: TypeAlias = tuple[float, float, float]
Float64Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """A camera: a pinhole, or with a radius of the lens, one that is sharp at one distance only.

    Parameters
    ----------
    origin : (3,) numbers
        Where all rays start.
    target : (3,) numbers
        The point in the middle of the picture.
    up : (3,) numbers
        The direction that points upwards in the picture. If it is parallel to the view, the coordinate axis furthest
        from the view replaces it.
    fov_degrees : float
        The vertical field of view, in (0, 180).
    lens_radius : float
        The radius of the lens, in the unit of the coordinates. Only pictures take it into account (`render`): what is
        not at the focus distance is blurred. All methods but `through_lens` are of a pinhole at the origin.
    focus_distance : float, optional
        The distance along the view at which the picture is in focus. By default that of the target.

    Raises
    ------
    InputError
        If a number is not finite, the origin is the target, ``up`` is zero, or the field of view or the lens is out of
        range.

    Examples
    --------
    >>> camera = Camera(origin=(0, 0, 4), target=(0, 0, 0))
    >>> origins, directions = camera.rays(width=3, height=1)
    >>> directions[1].tolist()
    [0.0, 0.0, -1.0]
    >>> pixels, depth = camera.project([[0, 0, 0]], width=3, height=1)
    >>> pixels.tolist(), depth.tolist()
    ([[1.5, 0.5]], [4.0])
    """

    origin: Vector
    target: Vector
    up: Vector = (0.0, 1.0, 0.0)
    fov_degrees: float = 30.0
    lens_radius: float = 0.0
    focus_distance: float | None = None

    def __post_init__(self) -> None:
        for name in ("origin", "target", "up"):
            object.__setattr__(self, name, _vector(getattr(self, name), name))
        _check_view(self.up, self.fov_degrees)
        check_fields(self, ("lens_radius",), number, "a radius: a finite number that is not negative", 0.0)
        check_fields(self, ("focus_distance",), number, "a distance: a finite number above 0", math.ulp(0.0))
        if self.origin == self.target:
            raise InputError(f"the camera's origin and target are both {self.origin}; move one of them")

    @property
    def focus(self) -> float:
        """The distance along the view at which the picture is in focus: `focus_distance`, or that of the target."""
        return math.dist(self.target, self.origin) if self.focus_distance is None else self.focus_distance

    def axes(self) -> Float64Array:
        """Return the unit vectors to the right, up and forward in the picture, as a (3, 3) float64 array."""
        return _axes(np.subtract(self.target, self.origin), self.up)

    def rays(self, width: int, height: int) -> tuple[AnyArray, FloatArray]:
        """Return rays through the pixel centres, row by row from the top left of a picture of this size.

        Origins and directions are (height * width, 3) float32, and directions of unit length. Origins are float64 where
        float32 is too coarse for the view.
        """
        directions = self.directions(width, height).reshape(-1, 3)
        return self._origins(directions), directions

    def directions(
        self, width: int, height: int, rows: slice | None = None, at: tuple[float, float] = (0.5, 0.5)
    ) -> FloatArray:
        """Return the directions of rays through one point of each pixel.

        Parameters
        ----------
        width, height : int
            The size of the whole picture in pixels.
        rows : slice, optional
            The rows, counted from the top; by default all.
        at : tuple of two floats
            The point in the pixel: rightwards and downwards from its top left corner, from 0 to 1.

        Returns
        -------
        Unit vectors, (n_rows, width, 3) float32.
        """
        tan_x, tan_y = self._tangents(width, height)
        right, up, forward = self.axes()
        x = ((np.arange(width) + at[0]) * (2 / width) - 1) * tan_x
        y = (1 - (np.arange(height)[rows or slice(None)] + at[1]) * (2 / height)) * tan_y
        directions = (forward + y[:, None] * up)[:, None] + x[:, None] * right
        directions /= np.sqrt((directions**2).sum(axis=2, keepdims=True))
        return np.asarray(directions, np.float32)

    def spread(self, height: int) -> float:
        """Return half a pixel's width at distance 1, for a picture of this height: tan(fov / 2) / height.

        As the `spread` of a query it makes hits of what lies within half a pixel of a ray; n times this is a cone of n
        pixels across. It is exact for the ray in the middle of the picture. A pixel at an angle θ from there is
        narrower as its ray sees it, by cos θ to cos² θ, so that the cone of this spread covers a little more.

        Examples
        --------
        >>> round(Camera(origin=(0, 0, 4), target=(0, 0, 0), fov_degrees=90).spread(height=100), 9)
        0.01
        """
        return self._tangents(1, height)[1] / height

    def ray(self, x: npt.ArrayLike, y: npt.ArrayLike, width: int, height: int) -> tuple[AnyArray, FloatArray, float]:
        """Return the ray through a point of the picture, or through several, for picking.

        Parameters
        ----------
        x, y : number or array
            In pixels, as `project` returns them: rightwards and downwards from the top left corner. The centre of the
            pixel in column i and row j is (i + 0.5, j + 0.5). Points outside the picture have rays too.
        width, height : int
            The size of the picture in pixels.

        Returns
        -------
        origin, direction : (3,) or (…, 3) float32
            As `rays` returns them.
        spread : float
            That of half a pixel, ``self.spread(height)``.

        Examples
        --------
        >>> import fastlines as fl
        >>> camera = Camera(origin=(0, 0, 4), target=(0, 0, 0))
        >>> origin, direction, spread = camera.ray(320, 200, width=640, height=480)
        >>> tree = fl.build([[[-1, 0.19, 0], [1, 0.19, 0]]])
        >>> tree.any_hit(origin, direction, spread=6 * spread)       # within three pixels
        array(True)
        """
        try:
            x, y = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
        except (TypeError, ValueError) as error:
            raise InputError(f"x and y are not numbers, or arrays of one shape: {error}") from None
        if not (np.isfinite(x).all() and np.isfinite(y).all()):
            raise InputError("x and y hold values that are not finite; expected pixels from the top left corner")
        tan_x, tan_y = self._tangents(width, height)
        right, up, forward = self.axes()
        across, upwards = (x * (2 / width) - 1) * tan_x, (1 - y * (2 / height)) * tan_y
        columns = [along + upwards * u + across * r for along, u, r in zip(forward, up, right, strict=True)]
        length = np.sqrt(sum(column * column for column in columns))
        directions = np.stack([(column / length).astype(np.float32) for column in columns], axis=-1)
        return self._origins(directions), directions, self.spread(height)

    def through_lens(
        self, directions: npt.ArrayLike, u: npt.ArrayLike, v: npt.ArrayLike
    ) -> tuple[AnyArray, FloatArray]:
        """Return rays from points of the lens that meet the rays from the pinhole where they are in focus, as `rays`.

        Parameters
        ----------
        directions : (…, 3) array_like
            The directions of rays from the pinhole, as `ray` and `rays` return them.
        u, v : (…) array_like
            Uniform numbers from 0 to 1, which choose the point of the lens.

        Raises
        ------
        InputError
            If the shapes do not fit together, a number is out of range, or a direction does not point forward.

        Examples
        --------
        >>> camera = Camera(origin=(0, 0, 4), target=(0, 0, 0), lens_radius=0.5)
        >>> origins, directions = camera.through_lens([0, 0, -1], u=1.0, v=0.0)  # from the edge of the lens
        >>> (origins + 4 / -directions[2] * directions).round(6).tolist()  # it meets the target
        [0.0, 0.0, 0.0]
        """
        try:
            pinhole, u, v = (np.asarray(values, np.float64) for values in (directions, u, v))
        except (TypeError, ValueError) as error:
            raise InputError(f"directions, u and v cannot be read as arrays of numbers: {error}") from None
        if pinhole.shape[-1:] != (3,) or not pinhole.shape[:-1] == u.shape == v.shape:
            raise InputError(
                f"directions, u and v have shapes {pinhole.shape}, {u.shape} and {v.shape}; expected (…, 3), (…), (…)"
            )
        right, up, forward = self.axes()
        depth = dot(pinhole, forward)
        if not (depth > 0).all():
            raise InputError("some directions do not point forward; expected those that `ray` returns")
        if not ((u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)).all():
            raise InputError("u or v hold values that are not from 0 to 1; expected uniform random numbers")
        radius, turn = (self.lens_radius * np.sqrt(u))[..., None], 2 * np.pi * v[..., None]
        on_lens = radius * (np.cos(turn) * right + np.sin(turn) * up)
        ways = (self.focus / depth)[..., None] * pinhole - on_lens
        ways /= np.sqrt(dot(ways, ways))[..., None]
        return self._origins(on_lens, on_lens), np.asarray(ways, np.float32)

    def orbit(self, degrees: float) -> Camera:
        """Return the camera after a turn about the upward axis through its target; from above, counter-clockwise.

        Examples
        --------
        >>> [round(x, 6) for x in Camera(origin=(0, 1, 4), target=(0, 0, 0)).orbit(90).origin]
        [4.0, 1.0, 0.0]
        """
        if not math.isfinite(degrees):
            raise InputError(f"degrees={degrees!r}; expected a finite angle")
        axis, offset = _unit(self.up), np.subtract(self.origin, self.target)
        cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        turned = cos * offset + sin * np.cross(axis, offset) + (1 - cos) * dot(axis, offset) * axis
        return replace(self, origin=_vector(self.target + turned, "origin"))

    def project(self, points: npt.ArrayLike, width: int, height: int) -> tuple[Float64Array, Float64Array]:
        """Find where points appear in the picture.

        Parameters
        ----------
        points : (m, 3) array
        width, height : int
            The size of the picture in pixels.

        Returns
        -------
        pixels : (m, 2) float64
            x to the right and y downwards from the top left corner: the first pixel's centre is (0.5, 0.5).
            NaN for points that are not in front of the camera.
        depth : (m,) float64
            The distance along the view, negative behind the camera.
        """
        tangents = self._tangents(width, height)
        right, up, forward = self.axes()
        offsets = _points(points) - self.origin
        depth = dot(offsets, forward)
        in_front = np.where(depth > 0, depth, np.nan)[:, None]
        plane = np.stack([dot(offsets, right), -dot(offsets, up)], axis=1) / (in_front * tangents)
        return (plane + 1) * (width / 2, height / 2), depth

    @classmethod
    def framing(
        cls,
        geometry: AnyGeometry | npt.ArrayLike,
        direction: npt.ArrayLike = (0.0, 0.0, -1.0),
        up: npt.ArrayLike = (0.0, 1.0, 0.0),
        fov_degrees: float = 30.0,
        aspect: float = 1.0,
        margin: float = 0.025,
        radius: float = 0.0,
    ) -> Camera:
        """Look along a direction from the least distance that shows everything.

        Parameters
        ----------
        geometry : Lines, Geometry or another container, (2, 3) array or (..., 3) array
            What to show: all primitives, a box as its lowest and highest corner, or points. Without any
            points, and for an empty box (lowest > highest), the camera looks at the coordinate origin.
        direction, up : (3,) numbers
            The direction of view, and the upward direction in the picture.
        fov_degrees : float
            The vertical field of view.
        aspect : float
            Width / height of the picture.
        margin : float
            The free space at each side of the frame, as a fraction of its width or height; in [0, 0.5).
        radius : float
            Added to the radius of what is shown, as that of a query.

        Examples
        --------
        >>> camera = Camera.framing([[0, 0, 0], [1, 1, 1]], direction=(0, 0, -1))  # a box
        >>> pixels, depth = camera.project([[0, 0, 1], [1, 1, 1]], width=200, height=200)
        >>> pixels.round(6).tolist()
        [[5.0, 195.0], [195.0, 5.0]]
        """
        view, upwards = _vector(direction, "direction"), _vector(up, "up")
        _check_view(upwards, fov_degrees)
        if not any(view):
            raise InputError("direction is zero; expected the direction of view, such as (0, 0, -1)")
        if not (0 < aspect < math.inf and 0 <= margin < 0.5):
            raise InputError(f"aspect={aspect!r}, margin={margin!r}; expected aspect > 0 and 0 <= margin < 0.5")
        points, radii = _to_frame(geometry)
        radii = radii + number("radius", radius, "a number from 0 to 1e38", 0.0, 1e38)
        offset = geometry.offset if isinstance(geometry, AnyGeometry) else 0.0

        # Work relative to the middle of the geometry: it may lie far from the coordinate origin.
        low = np.array([(column - radii).min() for column in points.T])
        high = np.array([(column + radii).max() for column in points.T])
        centre = low + (high - low) / 2
        largest = float(np.abs(centre).max())
        size = max(1.0, 1e-3 * largest) if is_point(low, high) else float((high - low).max())
        axes = _axes(view, upwards)
        x, y, depth = dot((points - centre)[None], axes[:, None])

        # Put the apex of the frame's pyramid where two opposite sides touch the balls around the points.
        tan = math.tan(math.radians(fov_degrees) / 2) * (1 - 2 * margin)
        middle, nearest = [], [(depth - radii).min() - 0.01 * size]
        for across, slope in ((x, tan * aspect), (y, tan)):
            grown = radii * math.sqrt(1 + slope**2)
            upper, lower = (across - slope * depth + grown).max(), (across + slope * depth - grown).min()
            middle.append((lower + upper) / 2)
            nearest.append((lower - upper) / (2 * slope))
        apex = centre + dot(axes.T, np.array([*middle, min(nearest)]))
        target = apex - min(nearest) * axes[2]
        return cls(_vector(apex + offset, "origin"), _vector(target + offset, "target"), upwards, fov_degrees)

    def _origins(self, like: AnyArray, beside: npt.ArrayLike = 0.0) -> AnyArray:
        """Return the origin as often as `like` has vectors, or points beside it, in float64 if float32 is coarse."""
        is_coarse = max(map(abs, self.origin)) * 2.0**-24 > math.dist(self.origin, self.target) * COARSE
        return np.full(like.shape, np.add(self.origin, beside), np.float64 if is_coarse else np.float32)

    def _tangents(self, width: int, height: int) -> tuple[float, float]:
        """Return half the extent of the picture at depth 1."""
        tan = math.tan(math.radians(self.fov_degrees) / 2)
        return tan * count("width", width, 1) / count("height", height, 1), tan


def _check_view(up: Vector, fov_degrees: float) -> None:
    if not 0 < fov_degrees < 180:
        raise InputError(f"fov_degrees={fov_degrees!r}; expected an angle between 0 and 180")
    if not any(up):
        raise InputError("the camera's up is zero; expected a direction such as (0, 1, 0)")


def _axes(view: npt.ArrayLike, up: npt.ArrayLike) -> Float64Array:
    """Return right, up and forward; vectors are scaled first, so that their squares do not over- or underflow."""
    forward = _unit(view)
    right = np.cross(forward, _unit(up))
    if np.abs(right).max() < 1e-6:
        right = np.cross(forward, np.eye(3)[np.abs(forward).argmin()])
    right = _unit(right)
    return np.stack([right, np.cross(right, forward), forward])


def _unit(vector: npt.ArrayLike) -> Float64Array:
    scaled = np.asarray(vector, np.float64) / np.abs(vector).max()
    return np.asarray(scaled / np.sqrt((scaled**2).sum()))


def _to_frame(geometry: AnyGeometry | npt.ArrayLike) -> tuple[Float64Array, Float64Array]:
    """Return the points that a picture must show, at least one, less the offset, and the radius around each."""
    if isinstance(geometry, AnyGeometry):
        known, radii = geometry.span()
        if len(known):
            return known.astype(np.float64), radii.astype(np.float64)
        geometry = []
    elif np.shape(geometry) == (2, 3):
        low, high = np.asarray(geometry, np.float64)
        geometry = [] if (low > high).all() else list(itertools.product(*zip(low, high, strict=True)))
    points = given if len(given := _points(geometry)) else np.zeros((1, 3))
    return points, np.zeros(len(points))


def _points(values: npt.ArrayLike) -> Float64Array:
    try:
        points = np.asarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"points cannot be read as an array of numbers: {error}") from None
    if points.size == 0:
        return np.empty((0, 3))
    if points.shape[-1:] != (3,) or not np.isfinite(points).all():
        raise InputError(f"points have shape {points.shape}; expected (m, 3) finite numbers")
    return points.reshape(-1, 3)


def _vector(values: npt.ArrayLike, name: str) -> Vector:
    try:
        x, y, z = (float(value) for value in np.asarray(values, np.float64))
    except (TypeError, ValueError):
        raise InputError(f"{name}={values!r}; expected three numbers") from None
    if not all(map(math.isfinite, (x, y, z))):
        raise InputError(f"{name}={values!r}; expected finite numbers")
    return x, y, z
