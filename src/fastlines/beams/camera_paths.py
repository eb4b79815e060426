"""Rays of a camera, through mirrors and glass: the legs of them that lie in the medium."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import IntArray
from ..support.counter_random import Float64Array, UInt64Array, random_bits, uniform
from .scene import BeamScene

#: A ray that carries less than this of the light behind it may end by chance.
FAINT = 0.05
#: How often a ray is reflected or refracted at most.
MAX_LEGS = 64


class Legs(NamedTuple):
    """Straight parts of n rays in the medium.

    Attributes
    ----------
    rays : (n,) int64
        The rays that they are parts of, in order.
    origins, directions : (n, 3) float64
        Directions are unit vectors.
    lengths : (n,) float64
        Above 0.
    throughput : (n, 3) float64
        The fraction of the light at the origin that reaches the camera.
    """

    rays: IntArray
    origins: Float64Array
    directions: Float64Array
    lengths: Float64Array
    throughput: Float64Array

    def some(self, rows: slice) -> Legs:
        """Return the legs in some rows."""
        return Legs(self.rays[rows], *(column[rows] for column in self[1:]))


def camera_legs(
    scene: BeamScene, origins: Float64Array, directions: Float64Array, keys: UInt64Array, max_legs: int = MAX_LEGS
) -> Iterator[Legs]:
    """Follow rays from surface to surface, and yield their legs in the medium, the first ones of all rays first.

    A ray ends where it leaves the scene and at surfaces that are not specular.

    Parameters
    ----------
    scene : BeamScene
    origins, directions : (n, 3) float64
        Outside of glass. Directions are unit vectors.
    keys : (n,) uint64
        Of the random numbers of each ray, by which glass reflects or refracts.
    max_legs : int
        How many legs a ray has at most.
    """
    rays, throughput = np.arange(len(origins)), np.ones((len(origins), 3))
    in_medium = np.ones(len(origins), np.bool_)
    for leg in range(max_legs):
        hits = scene.surfaces.intersect(origins, directions)
        begin, end = scene.in_box(origins, directions)
        end = np.minimum(end, hits.t)
        inside = np.flatnonzero(in_medium & (begin < end))
        if len(inside):
            start = origins[inside] + begin[inside, None] * directions[inside]
            lengths = (end - begin)[inside]
            yield Legs(rays[inside], start, directions[inside], lengths, throughput[inside])
            throughput[inside] *= scene.medium.transmittance(start, directions[inside], lengths)

        # Go on behind mirrors and glass, and let chance end faint rays.
        rows = np.flatnonzero(np.isfinite(hits.t))
        if not len(rows):
            return
        event = random_bits(keys[rows], leg)
        scattered = hits.scatter(rows, in_medium[rows], random_bits(event, 0), camera=True)
        carried = throughput[rows] * scattered.weight
        chance = np.minimum(carried.max(axis=1) / FAINT, 1)
        on = np.flatnonzero(scattered.is_specular & (uniform(event, 1) < chance))
        rays, keys, throughput = rays[rows[on]], keys[rows[on]], carried[on] / chance[on, None]
        origins, directions, in_medium = scattered.origins[on], scattered.directions[on], scattered.in_medium[on]
