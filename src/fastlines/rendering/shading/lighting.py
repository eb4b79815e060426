"""Lights: a key, a fill and a rim light that stand around the camera, and a sky.

Compiled code samples lights (`cpp/fastlines/shading/lights.hpp`). `Light.sample`, `Sky.radiance`, `sphere` and
`hemisphere` define what it computes, and tests compare the two.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray, check_fields, did_you_mean, instance, number
from ...camera import Camera, Float64Array, Vector
from ...errors import InputError
from ...support.vectors import unit

#: A whole turn in radians.
TURN = 2 * np.pi
#: What is expected of the colour of a light.
LIGHT = "a colour: three numbers that are not negative, linear red, green and blue"


def _three(name: str, values: object, expected: str, least: float) -> Vector:
    """Return three finite numbers, each at least the least."""
    found = tuple(values) if isinstance(values, Iterable) else ()
    if len(found) != 3:
        raise InputError(f"{name}={values!r}; expected {expected}")
    x, y, z = (number(name, value, expected, max(least, -sys.float_info.max)) for value in found)
    return x, y, z


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
        The radius of its disc in degrees, from 0 to less than 90; the larger it is, the softer are shadows.

    Raises
    ------
    InputError
        If a number is not finite or out of range, or the direction is zero.

    Examples
    --------
    >>> import fastlines as fl
    >>> lamp = fl.Light((-1, 1, 1), color=(6, 5, 4))                # from the upper left, warm
    >>> picture = fl.render([[[0, 0, 0], [1, 1, 1]]], rig=fl.Rig([lamp]), width=32, samples=1)
    >>> picture.rig.lights[0].color
    (6.0, 5.0, 4.0)
    """

    direction: Vector
    color: Vector = (1.0, 1.0, 1.0)
    angle: float = 2.0

    def __post_init__(self) -> None:
        check_fields(self, ("direction",), _three, "a direction: three finite numbers, not all 0", -math.inf)
        if not any(self.direction):
            raise InputError(f"direction={self.direction!r}; expected a direction: three finite numbers, not all 0")
        check_fields(self, ("color",), _three, LIGHT, 0.0)
        check_fields(self, ("angle",), number, "an angle: a number of degrees from 0 to less than 90", 0.0, 89.99)

    def sample(self, camera: Camera, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return unit vectors towards points of the light, one for each pair of uniform numbers, (n, 3)."""
        towards, radius, other = self.disc(camera)
        away, turn = np.sqrt(first), TURN * second
        return unit(towards + (away * np.cos(turn))[:, None] * radius + (away * np.sin(turn))[:, None] * other)

    def disc(self, camera: Camera) -> Float64Array:
        """Return the unit vector towards the light, and two radii of its disc at that distance, as rows.

        Examples
        --------
        >>> import fastlines as fl
        >>> print(Light((0, 0, 1), angle=45).disc(fl.Camera(origin=(0, 0, 4), target=(0, 0, 0))).round(6))
        [[ 0.  0.  1.]
         [ 0.  1.  0.]
         [-1.  0.  0.]]
        """
        right, up, forward = camera.axes()
        towards = self.direction[0] * right + self.direction[1] * up - self.direction[2] * forward
        towards /= np.sqrt((towards**2).sum())
        return np.stack([towards, *np.tan(np.radians(self.angle)) * np.stack(perpendicular(towards))])


@dataclass(frozen=True)
class Sky:
    """Light from all directions: its radiance at the top, at the horizon and at the bottom, linear RGB."""

    top: Vector = (0.55, 0.62, 0.72)
    horizon: Vector = (0.42, 0.42, 0.44)
    bottom: Vector = (0.20, 0.17, 0.14)

    def __post_init__(self) -> None:
        check_fields(self, ("top", "horizon", "bottom"), _three, LIGHT, 0.0)

    def radiance(self, height: FloatArray) -> FloatArray:
        """Return the radiance from directions whose upward parts are given, (n, 3)."""
        top, horizon, bottom = (np.asarray(color, np.float32) for color in (self.top, self.horizon, self.bottom))
        up, down = np.maximum(height, 0)[:, None], np.maximum(-height, 0)[:, None]
        return np.asarray(horizon + up * (top - horizon) + down * (bottom - horizon))

    def row(self, up: FloatArray) -> FloatArray:
        """Return an upward direction and the radiance there and elsewhere, (12,), as compiled shading takes them."""
        top, horizon, bottom = (np.asarray(color, np.float32) for color in (self.top, self.horizon, self.bottom))
        return np.concatenate([up, horizon, top - horizon, bottom - horizon], dtype=np.float32)


@dataclass(frozen=True)
class Rig:
    """The lights of a picture: distant ones, and the sky. `RIGS` has those of the looks."""

    lights: Sequence[Light]
    sky: Sky = field(default_factory=Sky)

    def __post_init__(self) -> None:
        if not isinstance(self.lights, Sequence) or not all(isinstance(light, Light) for light in self.lights):
            raise InputError(f"lights={self.lights!r}; expected a list of Light, which may be empty")
        object.__setattr__(self, "lights", tuple(self.lights))
        instance("sky", self.sky, Sky, "a Sky")

    def rows(self, camera: Camera) -> FloatArray:
        """Return the disc and the colour of each distant light, (n_lights, 12), as compiled shading takes them."""
        found = [np.append(light.disc(camera), light.color) for light in self.lights]
        return np.array(found, np.float32).reshape(-1, 12)


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

#: The lights of the looks by name: of tubes, of hair, and of fibres.
RIGS = {"studio": STUDIO, "salon": SALON, "soft": SOFT}


def find_rig(rig: object) -> Rig | None:
    """Return a rig that is given or named; None if there is none.

    Examples
    --------
    >>> find_rig("salon") is SALON
    True
    """
    if isinstance(rig, str):
        if rig not in RIGS:
            raise InputError(f"there is no rig {rig!r}{did_you_mean(rig, tuple(RIGS))}")
        return RIGS[rig]
    if not (rig is None or isinstance(rig, Rig)):
        raise InputError(f"rig={rig!r}; expected a Rig, or the name of one: {', '.join(RIGS)}")
    return rig


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
