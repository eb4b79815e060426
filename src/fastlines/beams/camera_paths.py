"""Rays of a camera, through mirrors and glass: the legs of them that lie in the medium."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import IntArray
from ..support.counter_random import Float64Array, UInt64Array, random_bits, uniform
from .coefficients import BoolArray
from .scene import BeamScene
from .surfaces import SurfaceHits

#: A ray that carries less than this of the light behind it may end by chance.
FAINT = 0.05
#: At how many surfaces a ray goes all ways that it may, and how often it is scattered there to find them.
MAX_SPLITS, TRIALS = 2, 8
#: How often a ray is reflected or refracted at most.
MAX_LEGS = 64


class Legs(NamedTuple):
    """Straight parts of n rays in the medium.

    Attributes
    ----------
    rays : (n,) int64
        The rays that they are parts of. A ray that glass has split may have several.
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
    """Follow rays from surface to surface; yield their legs in the medium: first legs, then second ones, and so on.

    A ray ends where it leaves the scene and at surfaces that are not specular. At its first surfaces it goes both ways
    where it may be reflected or refracted.

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

        # Go on behind mirrors and glass, both ways where light may go two; let chance end faint rays.
        rows = np.flatnonzero(np.isfinite(hits.t))
        if not len(rows):
            return
        found = _outcomes(hits, rows, in_medium[rows], random_bits(keys[rows], leg), TRIALS if leg < MAX_SPLITS else 1)
        carried = throughput[rows[found.row]] * found.share
        chance = np.minimum(carried.max(axis=1, initial=0) / FAINT, 1)
        on = np.flatnonzero(uniform(found.keys, 0) < chance)
        rays, throughput = rays[rows[found.row[on]]], carried[on] / chance[on, None]
        keys, origins, directions = random_bits(found.keys[on], 1), found.origins[on], found.directions[on]
        in_medium = found.in_medium[on]


class _Outcomes(NamedTuple):
    """The different ways that rays go on from surfaces, k in all: the row of each, and its share of the throughput."""

    row: IntArray
    origins: Float64Array
    directions: Float64Array
    in_medium: BoolArray
    share: Float64Array
    keys: UInt64Array


def _outcomes(hits: SurfaceHits, rows: IntArray, in_medium: BoolArray, keys: UInt64Array, n_trials: int) -> _Outcomes:
    """Scatter rays several times, and return each way that they go once, with its mean weight in all trials."""
    trials = [hits.scatter(rows, in_medium, random_bits(keys, i), camera=True) for i in range(n_trials)]
    origins, directions, weights, sides, is_specular = map(np.stack, zip(*trials, strict=True))
    left = np.asarray((weights.max(axis=2) > 0) & is_specular, np.bool_)
    found: list[_Outcomes] = []
    while not found or left.any():
        # Take the first trial of each row that is left, and with it those that went the same way.
        row = np.flatnonzero(left.any(axis=0))
        first = left[:, row].argmax(axis=0), row
        same = left[:, row] & (directions[:, row] == directions[first]).all(axis=2)
        left[:, row] &= ~same
        share = (weights[:, row] * same[..., None]).sum(axis=0) / n_trials
        own_keys = random_bits(keys[row], n_trials + len(found))
        found.append(_Outcomes(row, origins[first], directions[first], sides[first], share, own_keys))
    return _Outcomes(*map(np.concatenate, zip(*found, strict=True)))
