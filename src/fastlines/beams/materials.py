"""Materials of surfaces: mirrors, glass, diffuse walls.

A material turns the directions of light, and says what is left of its power. It works for photons and, backwards, for
rays of a camera, because all three are symmetric here: light and cameras are outside of glass, so the factor n² that
radiance gains on its way into glass is lost on the way out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..arrays import number
from ..camera import Vector
from ..support.counter_random import Float64Array, UInt64Array, uniform
from ..support.unit_directions import turned
from ..support.vectors import dot
from .coefficients import BoolArray, rgb


class Turn(NamedTuple):
    """How light goes on.

    Attributes
    ----------
    directions : (n, 3) float64
        Unit vectors.
    weight : (n, 3) float64
        What is left of the power.
    passes : (n,) bool
        Whether it goes through the surface; else it is reflected.
    """

    directions: Float64Array
    weight: Float64Array
    passes: BoolArray


class Material(Protocol):
    """What a surface asks of its material.

    Attributes
    ----------
    is_specular : bool
        Whether light goes on in one or two directions alone, so that a camera's ray follows it.
    """

    is_specular: ClassVar[bool]

    def turn(self, directions: Float64Array, normals: Float64Array, keys: UInt64Array) -> Turn:
        """Turn light that flies in unit directions (n, 3) and hits a surface with these outward unit normals."""


@dataclass(frozen=True)
class Mirror:
    """A perfect mirror.

    Parameters
    ----------
    reflectance : number or (3,) numbers
        The fraction of the light that is reflected, from 0 to 1.

    Examples
    --------
    >>> down, up, key = np.array([[0.0, 0.6, -0.8]]), np.array([[0.0, 0.0, 1.0]]), np.zeros(1, np.uint64)
    >>> Mirror(0.9).turn(down, up, key).directions.round(6).tolist()
    [[0.0, 0.6, 0.8]]
    """

    is_specular: ClassVar[bool] = True
    reflectance: Vector

    def __init__(self, reflectance: npt.ArrayLike = 1.0) -> None:
        object.__setattr__(self, "reflectance", rgb("reflectance", reflectance, "of the light", most=1.0))

    def turn(self, directions: Float64Array, normals: Float64Array, keys: UInt64Array) -> Turn:
        """See `Material`."""
        weight = np.broadcast_to(self.reflectance, directions.shape)
        return Turn(reflected(directions, normals), weight, np.zeros(len(directions), np.bool_))


@dataclass(frozen=True)
class Diffuse:
    """A matt surface (Lambert), the same on both sides.

    Parameters
    ----------
    reflectance : number or (3,) numbers
        The fraction of the light that is reflected, from 0 to 1.
    """

    is_specular: ClassVar[bool] = False
    reflectance: Vector

    def __init__(self, reflectance: npt.ArrayLike = 0.5) -> None:
        object.__setattr__(self, "reflectance", rgb("reflectance", reflectance, "of the light", most=1.0))

    def turn(self, directions: Float64Array, normals: Float64Array, keys: UInt64Array) -> Turn:
        """See `Material`."""
        facing = np.where(dot(directions, normals) > 0, -1.0, 1.0)[:, None] * normals
        cosine = np.sqrt(1 - uniform(keys, 0))
        weight = np.broadcast_to(self.reflectance, directions.shape)
        return Turn(turned(facing, cosine, uniform(keys, 1)), weight, np.zeros(len(directions), np.bool_))


@dataclass(frozen=True)
class Glass:
    """Smooth glass, water or another dielectric, without absorption; there is no medium in it.

    Light is reflected with the probability of Fresnel's equations, and refracted by Snell's law otherwise.

    Parameters
    ----------
    ior : float
        The index of refraction of the inside, relative to that of the outside.
    transmittance : number or (3,) numbers
        The fraction of refracted light that passes the surface, from 0 to 1.

    Examples
    --------
    >>> float(fresnel(np.array([1.0]), 1.5)[0].round(4))  # straight on
    0.04
    """

    is_specular: ClassVar[bool] = True
    ior: float = 1.5
    transmittance: Vector = (1.0, 1.0, 1.0)

    def __init__(self, ior: float = 1.5, transmittance: npt.ArrayLike = 1.0) -> None:
        object.__setattr__(self, "ior", number("ior", ior, "an index of refraction from 0.1 to 10", 0.1, 10.0))
        object.__setattr__(self, "transmittance", rgb("transmittance", transmittance, "of the light", most=1.0))

    def turn(self, directions: Float64Array, normals: Float64Array, keys: UInt64Array) -> Turn:
        """See `Material`."""
        cosine = -dot(directions, normals)
        enters = cosine > 0
        facing, cosine = np.where(enters[:, None], normals, -normals), np.abs(cosine)
        # The index of the side that light comes to, relative to the side that it comes from.
        ior = np.where(enters, self.ior, 1 / self.ior)
        passes = uniform(keys, 0) >= fresnel(cosine, ior)
        inner = np.sqrt(np.maximum(1 - (1 - cosine**2) / ior**2, 0))
        bent = directions / ior[:, None] + (cosine / ior - inner)[:, None] * facing
        bent /= np.sqrt(dot(bent, bent))[:, None]
        turned_to = np.where(passes[:, None], bent, reflected(directions, facing))
        return Turn(turned_to, np.where(passes[:, None], self.transmittance, 1.0), passes)


def reflected(directions: Float64Array, normals: Float64Array) -> Float64Array:
    """Return the mirror images of unit directions, as unit vectors."""
    mirrored = directions - 2 * dot(directions, normals)[:, None] * normals
    return np.asarray(mirrored / np.sqrt(dot(mirrored, mirrored))[:, None])


def fresnel(cosine: Float64Array, ior: Float64Array | float) -> Float64Array:
    """Return the fraction of unpolarised light that a dielectric reflects; 1 where none can pass.

    Parameters
    ----------
    cosine : (n,) float64
        Of the angle to the normal, not negative.
    ior : (n,) float64 or float
        The index of refraction behind the surface, relative to that before it.
    """
    sine2 = (1 - cosine**2) / np.square(ior)
    inner = np.sqrt(np.maximum(1 - sine2, 0))
    across = (cosine - ior * inner) / (cosine + ior * inner)
    along = (ior * cosine - inner) / (ior * cosine + inner)
    return np.where(sine2 >= 1, 1.0, (across**2 + along**2) / 2)
