"""Photon beams: paths of light in a mirrored cube filled with a homogeneous translucent medium (thesis §6).

A point light at `LIGHT` in the unit cube emits photons uniformly in all directions. Each flies a free path,
exponential with the mean 1 / `EXTINCTION`. At its end it is scattered with the probability `ALBEDO`, or else absorbed
(Russian roulette). The scattering angle follows Henyey and Greenstein with the mean cosine `G`.

The walls are perfect mirrors (reflectance 1). So only the medium ends a path, on average after 1 / (`EXTINCTION` · (1 −
`ALBEDO`)) ≈ 8.3 units of length. Where a free path hits a wall, the rest of it continues after the reflection. Each
flight, from the light, a wall or a scattering to the next wall, scattering or absorption, is a segment.

Every photon has its own stream of random numbers, and takes only its key from the generator of the scene. So a
photon's path does not depend on how many others are traced with it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..geometry.lines import Lines
from ..support.counter_random import Float64Array, UInt64Array, uniform
from ..support.phase_function import scattering_cosine
from ..support.unit_directions import isotropic, turned

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
    direction = isotropic(uniform(keys, 0), uniform(keys, 1))
    path = _free_path(uniform(keys, 2))
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
        roulette, xi, azimuth, length = (uniform(keys[inside], draw + i) for i in range(4))
        draw += 4
        direction[inside] = turned(direction[inside], scattering_cosine(G, xi), azimuth)
        path[inside] = _free_path(length)
        alive = reflected
        alive[inside] = roulette < ALBEDO
        position = end[alive]
        photon, keys, direction, path = photon[alive], keys[alive], direction[alive], path[alive]

    photons = np.concatenate(all_photons)
    order = np.argsort(photons, kind="stable")
    return np.concatenate(all_flights)[order], photons[order]


def _free_path(xi: Float64Array) -> Float64Array:
    return np.asarray(-np.log1p(-xi) / EXTINCTION)
