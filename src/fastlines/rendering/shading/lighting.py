"""Lights: a key, a fill and a rim light that stand around the camera, and a sky."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ...camera import Camera, Float64Array, Vector
from ...support.vectors import unit

#: A whole turn in radians.
TURN = 2 * np.pi


@dataclass(frozen=True)
class Light:
    """A distant light.

    Parameters
    ----------
    direction : (3,) numbers
        Towards the light: right, up and backwards as the camera sees it.
    color : (3,) numbers
        The irradiance on a surface that faces the light, linear red, green and blue.
    angle : float
        The radius of its disc in degrees; the larger it is, the softer are shadows.
    """

    direction: Vector
    color: Vector = (1.0, 1.0, 1.0)
    angle: float = 2.0

    def sample(self, camera: Camera, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return unit vectors towards points of the light, one for each pair of uniform numbers, (n, 3)."""
        right, up, forward = camera.axes()
        towards = self.direction[0] * right + self.direction[1] * up - self.direction[2] * forward
        towards /= np.sqrt((towards**2).sum())
        one, other = perpendicular(towards)
        radius, turn = np.tan(np.radians(self.angle)) * np.sqrt(first), TURN * second
        vectors = towards + (radius * np.cos(turn))[:, None] * one + (radius * np.sin(turn))[:, None] * other
        return unit(vectors)


@dataclass(frozen=True)
class Sky:
    """Light from all directions: its radiance at the top, at the horizon and at the bottom."""

    top: Vector = (0.55, 0.62, 0.72)
    horizon: Vector = (0.42, 0.42, 0.44)
    bottom: Vector = (0.20, 0.17, 0.14)

    def radiance(self, height: FloatArray) -> FloatArray:
        """Return the radiance from directions whose upward parts are given, (n, 3)."""
        top, horizon, bottom = (np.asarray(color, np.float32) for color in (self.top, self.horizon, self.bottom))
        up, down = np.maximum(height, 0)[:, None], np.maximum(-height, 0)[:, None]
        return np.asarray(horizon + up * (top - horizon) + down * (bottom - horizon))


@dataclass(frozen=True)
class Rig:
    """The lights of a picture: distant ones, and the sky."""

    lights: tuple[Light, ...]
    sky: Sky = field(default_factory=Sky)


#: A key light from the upper left, a fill light, and a rim light from behind.
STUDIO = Rig(
    (
        Light((-0.55, 0.85, 0.75), (7.0, 6.7, 6.2), 6.0),
        Light((0.9, 0.25, 0.8), (1.2, 1.3, 1.6), 20.0),
        Light((0.45, 0.7, -1.0), (4.0, 4.2, 4.6), 5.0),
    )
)
#: For hair: a strong key light for highlights, a dim sky, for hair hides itself, and a rim light for the outline.
SALON = Rig(
    (
        Light((-0.55, 0.75, 0.75), (10.2, 9.8, 9.1), 3.0),
        Light((0.9, 0.25, 0.8), (2.2, 2.3, 2.5), 20.0),
        Light((0.4, 0.8, -0.9), (5.8, 6.0, 6.6), 5.0),
    ),
    Sky((0.40, 0.43, 0.48), (0.33, 0.33, 0.34), (0.17, 0.16, 0.15)),
)
#: One large soft light and a bright sky, for colours that can be told apart everywhere.
SOFT = Rig(
    (Light((-0.4, 0.7, 1.0), (4.2, 4.2, 4.2), 25.0),),
    Sky((1.05, 1.05, 1.05), (0.85, 0.85, 0.85), (0.55, 0.55, 0.55)),
)


def sphere(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return unit vectors distributed evenly over the sphere, one for each pair of uniform numbers."""
    height = 1 - 2 * first
    radius, turn = np.sqrt(np.maximum(1 - height**2, 0)), np.float32(TURN) * second
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)


def hemisphere(normals: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Return unit vectors about normals, as many as the cosine of their angle, one for each pair of numbers."""
    return unit(normals + np.float32(0.9999) * sphere(first, second))


def perpendicular(axis: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return two unit vectors that are perpendicular to a unit vector and to each other."""
    one = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    one /= np.sqrt((one**2).sum())
    return one, np.cross(axis, one)
