"""The distances of pairs of round cones in float64, by search: D(s, t) − r₁(s) − r₂(t) is convex (docs/answers.md)."""

from __future__ import annotations

import numpy as np

from .exact_points import distance_from_cones
from .scenes import Array

#: Steps of the search: each leaves 0.618 of an interval.
N_STEPS = 75
GOLDEN = (np.sqrt(5) - 1) / 2


def distance_of_pairs(ends: Array, radii: Array, other_ends: Array, other_radii: Array) -> Array:
    """Return the distance of each of n round cones from the other one of its row, (n,): negative if they overlap.

    For a fixed s, the least value over t is that of a point. As a function of s it is convex, and a search by golden
    sections finds its least value. Both ends are tried, too.
    """

    def value(s: Array) -> Array:
        points = ends[:, 0] + s[:, None] * (ends[:, 1] - ends[:, 0])
        own = radii[:, 0] + s * (radii[:, 1] - radii[:, 0])
        return np.asarray(distance_from_cones(points, other_ends, other_radii, is_paired=True)[:, 0] - own)

    low, high = np.zeros(len(ends)), np.ones(len(ends))
    least = np.minimum(value(low), value(high))
    s, t = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_s, at_t = value(s), value(t)
    for _ in range(N_STEPS):
        is_left = at_s < at_t
        low, high = np.where(is_left, low, s), np.where(is_left, t, high)
        kept, at_kept = np.where(is_left, s, t), np.where(is_left, at_s, at_t)
        new = np.where(is_left, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        at_new = value(new)
        s, t = np.where(is_left, new, kept), np.where(is_left, kept, new)
        at_s, at_t = np.where(is_left, at_new, at_kept), np.where(is_left, at_kept, at_new)
        least = np.minimum(least, np.minimum(at_s, at_t))
    return least


def factor_of_tapers(ends: Array, radii: Array, other_ends: Array, other_radii: Array) -> Array:
    """Return how much wider the band of each pair is, (n,): 1 + κ / sin²θ.

    κ is the sum of the slopes of both radii, and θ the angle of the axes. The place where both derivatives vanish is
    found from the volume that the axes span, whose rounding counts κ / sin²θ times. Where κ is more than sin θ, there
    is no such place, and the ends count.
    """
    kappa, unit = np.zeros(len(ends)), []
    for line, radius in ((ends, radii), (other_ends, other_radii)):
        e = line[:, 1] - line[:, 0]
        length = np.sqrt((e**2).sum(axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            kappa = kappa + np.abs(radius[:, 1] - radius[:, 0]) / length
            unit.append(e / length[:, None])
    sine2 = (np.cross(*unit) ** 2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = 1 + kappa / sine2
    return np.where(np.isfinite(factor) & (kappa**2 <= 2 * sine2), factor, 1.0)
