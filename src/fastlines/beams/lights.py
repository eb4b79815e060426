"""Lights that emit photons: from a point, into a cone, from a rectangle, and from far away.

A light draws all random numbers of a photon from its key (`uniform`). Each of n photons carries a power whose mean is
the power of the light.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..arrays import number
from ..camera import Vector
from ..errors import InputError
from ..support.counter_random import Float64Array, UInt64Array, uniform
from ..support.unit_directions import isotropic, turned
from .coefficients import BoolArray, point, rgb, unit_direction

#: How far from the bounds of a scene a directional light starts, as a fraction of their size.
BEFORE = 1e-3


class Emission(NamedTuple):
    """The beginning of n photons.

    Attributes
    ----------
    origins : (n, 3) float64
    directions : (n, 3) float64
        Unit vectors.
    power : (n, 3) float64
        The power that each would carry if the light emitted one photon.
    in_medium : (n,) bool
        Whether each begins where the medium may be, and not in glass.
    """

    origins: Float64Array
    directions: Float64Array
    power: Float64Array
    in_medium: BoolArray


class Light(Protocol):
    """What photons ask of a light."""

    def total_power(self, bounds: Float64Array) -> Vector:
        """Return the power of the light in a scene of these bounds, (3,)."""

    def emit(self, keys: UInt64Array, bounds: Float64Array) -> Emission:
        """Emit a photon for each key, (n,) uint64, into a scene of these bounds."""


def _power_of(name: str, value: npt.ArrayLike) -> Vector:
    power = rgb(name, value, "of the light")
    if not any(power):
        raise InputError(f"{name}={value!r}; the light has no power: expected a number above 0 in some channel")
    return power


class _Powered:
    """The power of a light that does not depend on the scene."""

    power: Vector

    def total_power(self, bounds: Float64Array) -> Vector:
        """See `Light`."""
        return self.power

    def _emission(self, origins: npt.ArrayLike, directions: Float64Array) -> Emission:
        shape = directions.shape
        return Emission(
            np.broadcast_to(np.asarray(origins, np.float64), shape),
            directions,
            np.broadcast_to(self.power, shape),
            np.ones(len(directions), np.bool_),
        )


@dataclass(frozen=True)
class PointLight(_Powered):
    """A point that emits evenly in all directions.

    Parameters
    ----------
    position : (3,) numbers
    power : number or (3,) numbers
        The power of all directions together, in watts: for all channels, or for red, green and blue.

    Raises
    ------
    InputError
        If a number is not finite or the light has no power.

    Examples
    --------
    >>> PointLight((0, 1, 0), power=100).power
    (100.0, 100.0, 100.0)
    """

    position: Vector
    power: Vector

    def __init__(self, position: npt.ArrayLike, power: npt.ArrayLike) -> None:
        object.__setattr__(self, "position", point("position", position))
        object.__setattr__(self, "power", _power_of("power", power))

    def emit(self, keys: UInt64Array, bounds: Float64Array) -> Emission:
        """See `Light`."""
        return self._emission(self.position, isotropic(uniform(keys, 0), uniform(keys, 1)))


@dataclass(frozen=True)
class SpotLight(_Powered):
    """A point that emits evenly into a cone.

    Parameters
    ----------
    position : (3,) numbers
    target : (3,) numbers
        A point on the axis of the cone.
    power : number or (3,) numbers
        See `PointLight`.
    angle_degrees : float
        From the axis to the edge of the cone, above 0 and at most 180.

    Raises
    ------
    InputError
        As a `PointLight` does, and if the target is the position.

    Examples
    --------
    >>> SpotLight((0, 1, 0), target=(0, 0, 0), power=1, angle_degrees=10).angle_degrees
    10.0
    """

    position: Vector
    target: Vector
    power: Vector
    angle_degrees: float = 20.0

    def __init__(
        self, position: npt.ArrayLike, target: npt.ArrayLike, power: npt.ArrayLike, angle_degrees: float = 20.0
    ) -> None:
        object.__setattr__(self, "position", point("position", position))
        object.__setattr__(self, "target", point("target", target))
        if self.position == self.target:
            raise InputError(f"position and target are both {self.position}; move one of them")
        object.__setattr__(self, "power", _power_of("power", power))
        angle = number("angle_degrees", angle_degrees, "an angle above 0 and at most 180 degrees", 1e-6, 180.0)
        object.__setattr__(self, "angle_degrees", angle)

    def emit(self, keys: UInt64Array, bounds: Float64Array) -> Emission:
        """See `Light`."""
        axis = unit_direction("direction", np.subtract(self.target, self.position))
        cosine = 1 - uniform(keys, 0) * (1 - np.cos(np.radians(self.angle_degrees)))
        return self._emission(self.position, turned(np.tile(axis, (len(keys), 1)), cosine, uniform(keys, 1)))


@dataclass(frozen=True)
class AreaLight(_Powered):
    """A rectangle that emits from its front, as much as a diffuse surface in each direction.

    Parameters
    ----------
    corner : (3,) numbers
    edge_u, edge_v : (3,) numbers
        The two edges that meet at the corner. The front is on the side of their cross product.
    power : number or (3,) numbers
        See `PointLight`.

    Raises
    ------
    InputError
        As a `PointLight` does, and if the edges span no area.

    Examples
    --------
    >>> AreaLight((0, 1, 0), (1, 0, 0), (0, 0, 1), power=1).normal.tolist()
    [0.0, -1.0, 0.0]
    """

    corner: Vector
    edge_u: Vector
    edge_v: Vector
    power: Vector

    def __init__(
        self, corner: npt.ArrayLike, edge_u: npt.ArrayLike, edge_v: npt.ArrayLike, power: npt.ArrayLike
    ) -> None:
        for name, value in (("corner", corner), ("edge_u", edge_u), ("edge_v", edge_v)):
            object.__setattr__(self, name, point(name, value))
        object.__setattr__(self, "power", _power_of("power", power))
        if not np.cross(self.edge_u, self.edge_v).any():
            raise InputError(f"edge_u={self.edge_u} and edge_v={self.edge_v} span no area; expected two sides")

    @property
    def normal(self) -> Float64Array:
        """The unit vector across the front, (3,) float64."""
        return np.array(unit_direction("normal", np.cross(self.edge_u, self.edge_v))) + 0.0

    def emit(self, keys: UInt64Array, bounds: Float64Array) -> Emission:
        """See `Light`."""
        u, v = uniform(keys, 2)[:, None], uniform(keys, 3)[:, None]
        origins = np.asarray(self.corner) + u * self.edge_u + v * self.edge_v
        cosine = np.sqrt(1 - uniform(keys, 0))
        return self._emission(origins, turned(np.tile(self.normal, (len(keys), 1)), cosine, uniform(keys, 1)))


@dataclass(frozen=True)
class DirectionalLight:
    """Parallel light from far away, over the medium and all surfaces.

    Photons start from a disc that covers both, so where surfaces are much larger than the medium, few reach it.

    Parameters
    ----------
    direction : (3,) numbers
        In which the light flies.
    irradiance : number or (3,) numbers
        The power per area across the direction.

    Raises
    ------
    InputError
        If a number is not finite, the direction is zero or the light has no power.

    Examples
    --------
    >>> sun = DirectionalLight((0, -1, 0), irradiance=2)
    >>> bounds = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    >>> [round(watts, 3) for watts in sun.total_power(bounds)]  # through a disc around the bounds
    [18.85, 18.85, 18.85]
    """

    direction: Vector
    irradiance: Vector

    def __init__(self, direction: npt.ArrayLike, irradiance: npt.ArrayLike) -> None:
        object.__setattr__(self, "direction", unit_direction("direction", direction))
        object.__setattr__(self, "irradiance", _power_of("irradiance", irradiance))

    def total_power(self, bounds: Float64Array) -> Vector:
        """See `Light`."""
        area = np.pi * _half_diagonal(bounds) ** 2
        red, green, blue = (area * part for part in self.irradiance)
        return red, green, blue

    def emit(self, keys: UInt64Array, bounds: Float64Array) -> Emission:
        """Emit from a disc across the direction that covers the bounds, before all of the scene."""
        axis = np.tile(self.direction, (len(keys), 1))
        across = turned(axis, np.zeros(len(keys)), uniform(keys, 1))
        radius = _half_diagonal(bounds)
        offset = (radius * np.sqrt(uniform(keys, 0)))[:, None] * across - (radius * (1 + BEFORE)) * axis
        power = np.broadcast_to(self.total_power(bounds), offset.shape)
        return Emission(bounds.mean(axis=0) + offset, axis, power, np.ones(len(keys), np.bool_))


def _half_diagonal(bounds: Float64Array) -> float:
    return float(np.sqrt(((bounds[1] - bounds[0]) ** 2).sum())) / 2
