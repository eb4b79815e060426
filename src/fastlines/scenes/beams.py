"""Photon beams: paths of light in a mirrored cube filled with a homogeneous translucent medium (thesis §6).

A point light at `LIGHT` in the unit cube emits photons uniformly in all directions. Each flies a free path,
exponential with the mean 1 / `EXTINCTION`. At its end it is scattered with the probability `ALBEDO`, or else absorbed
(Russian roulette). The scattering angle follows Henyey and Greenstein (1941) with the mean cosine `G`. Inverting their
distribution at a uniform ξ gives (Witt 1977; Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., §11.3.1)

    cos θ = (1 + g² − ((1 − g²) / (1 − g + 2gξ))²) / 2g,     θ = 0 straight on.

The walls are perfect mirrors (reflectance 1). So only the medium ends a path, on average after 1 / (`EXTINCTION` · (1 −
`ALBEDO`)) ≈ 8.3 units of length. Where a free path hits a wall, the rest of it continues after the reflection. Each
flight, from the light, a wall or a scattering to the next wall, scattering or absorption, is a segment.

Every photon has its own stream of random numbers (SplitMix64: Steele, Lea, Flood 2014), and takes only its key from the
generator of the scene. So a photon's path does not depend on how many others are traced with it.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..camera import Float64Array
from ..geometry.lines import Lines

UInt64Array: TypeAlias = npt.NDArray[np.uint64]

LIGHT = (0.35, 0.6, 0.45)
EXTINCTION = 0.8
ALBEDO = 0.85
G = 0.3


def generate(n_segments: int, rng: np.random.Generator, batch: int = 4096) -> Lines:
    """Trace photons, `batch` at a time, until there are enough flights; the result does not depend on the batch.

    Each photon takes one 64-bit key of the generator. The strand of a segment is the number of its photon, counted from
    the light's first.

    Examples
    --------
    >>> lines = generate(100, np.random.default_rng(0))
    >>> lines.segments[0, 0].tolist() == np.float32(LIGHT).tolist()
    True
    """
    segments, photons = [], []
    n_flights = n_photons = 0
    while n_flights < n_segments:
        flights, photon = trace(rng.integers(2**64, size=batch, dtype=np.uint64))
        segments.append(flights)
        photons.append(photon + n_photons)
        n_flights += len(flights)
        n_photons += batch
    return Lines.from_segments(np.concatenate(segments)[:n_segments], strands=np.concatenate(photons)[:n_segments])


def trace(keys: UInt64Array) -> tuple[Float64Array, npt.NDArray[np.int64]]:
    """Follow photons from the light to their end, by the key (p,) of each photon's random numbers.

    Returns the flights (m, 2, 3), sorted by photon, and the photon (m,) of each.
    """
    photon = np.arange(len(keys))
    position = np.tile(LIGHT, (len(keys), 1))
    direction = _isotropic(_uniform(keys, 0), _uniform(keys, 1))
    path = _free_path(_uniform(keys, 2))
    all_flights, all_photons = [], []
    draw = 3
    while len(photon):
        # Fly to the scattering or to the wall, whichever is nearer.
        with np.errstate(divide="ignore", invalid="ignore"):
            to_walls = ((direction > 0) - position) / direction
        to_walls[direction == 0] = np.inf
        wall = to_walls.argmin(axis=1)
        at_wall = np.take_along_axis(to_walls, wall[:, None], axis=1)[:, 0]
        reflected = at_wall < path
        flown = np.where(reflected, at_wall, path)
        end = np.clip(position + flown[:, None] * direction, 0, 1)
        path = path - flown
        mirrored = np.flatnonzero(reflected), wall[reflected]
        end[mirrored] = direction[mirrored] > 0
        all_flights.append(np.stack([position, end], axis=1))
        all_photons.append(photon)

        # Turn at the walls; scatter or end inside. At a wall a photon leaves its four random numbers unused.
        direction[mirrored] *= -1
        inside = np.flatnonzero(~reflected)
        roulette, xi, azimuth, length = (_uniform(keys[inside], draw + i) for i in range(4))
        draw += 4
        direction[inside] = _scatter(direction[inside], xi, azimuth)
        path[inside] = _free_path(length)
        alive = reflected
        alive[inside] = roulette < ALBEDO
        position = end[alive]
        photon, keys, direction, path = photon[alive], keys[alive], direction[alive], path[alive]

    photons = np.concatenate(all_photons)
    order = np.argsort(photons, kind="stable")
    return np.concatenate(all_flights)[order], photons[order]


def _uniform(keys: UInt64Array, draw: int) -> Float64Array:
    """Return random numbers in [0, 1): output number `draw` of SplitMix64 for each key as its seed."""
    z = keys + np.uint64((draw + 1) * 0x9E3779B97F4A7C15 % 2**64)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return np.asarray((z >> np.uint64(11)) * 2.0**-53)


def _free_path(uniform: Float64Array) -> Float64Array:
    return np.asarray(-np.log1p(-uniform) / EXTINCTION)


def _isotropic(u: Float64Array, v: Float64Array) -> Float64Array:
    z, azimuth = 2 * u - 1, 2 * np.pi * v
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), z], axis=1)


def _scatter(direction: Float64Array, xi: Float64Array, azimuth: Float64Array) -> Float64Array:
    """Turn each direction by a Henyey–Greenstein angle."""
    cosine = (1 + G * G - ((1 - G * G) / (1 - G + 2 * G * xi)) ** 2) / (2 * G)
    sine = np.sqrt(np.maximum(0, 1 - cosine * cosine))
    azimuth = 2 * np.pi * azimuth
    across, over = sine * np.cos(azimuth), sine * np.sin(azimuth)

    # Two axes across the direction (Duff et al. 2017, "Building an orthonormal basis, revisited").
    x, y, z = direction.T
    sign = np.copysign(1.0, z)
    a = -1 / (sign + z)
    b = x * y * a
    turned = np.stack(
        [
            across * (1 + sign * x * x * a) + over * b + cosine * x,
            across * sign * b + over * (sign + y * y * a) + cosine * y,
            -across * sign * x - over * y + cosine * z,
        ],
        axis=1,
    )
    return np.asarray(turned / np.sqrt((turned**2).sum(axis=1, keepdims=True)))
