"""Crossings: hits of one ray and one strand whose intervals from t to t_out overlap."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray


def crossings(ray: IntArray, group: IntArray, t: FloatArray, t_out: FloatArray) -> IntArray:
    """Number the crossings of hits: those of the same ray and group whose intervals overlap have the same number.

    Examples
    --------
    >>> zero = np.zeros(4, np.int64)
    >>> crossings(zero, zero, np.array([0.0, 3, 1, 9]), np.array([2.0, 4, 2, 10])).tolist()
    [0, 1, 0, 2]
    """
    if not len(ray):
        return np.zeros(0, np.int64)
    order = _by_group(ray, group, t)
    ray, group, t, latest = ray[order], group[order], t[order], t_out[order]
    begins = np.ones(len(order), bool)
    begins[1:] = (ray[1:] != ray[:-1]) | (group[1:] != group[:-1])
    # Find the largest t_out up to each hit of its group, over twice as many hits each time.
    place = np.arange(len(order)) - np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))
    step = 1
    while (later := np.flatnonzero(place >= step)).size:
        latest[later] = np.maximum(latest[later], latest[later - step])
        step *= 2
    # A hit that begins behind all hits before it begins a new crossing.
    begins[1:] |= t[1:] > latest[:-1]
    found = np.empty(len(order), np.int64)
    found[order] = np.cumsum(begins) - 1
    return found


def _by_group(ray: IntArray, group: IntArray, t: FloatArray) -> IntArray:
    """Return the order by ray, group and t; lists of hits are mostly by ray and t already."""
    n_groups = int(group.max()) + 1
    is_sorted = ((ray[1:] > ray[:-1]) | ((ray[1:] == ray[:-1]) & (t[1:] >= t[:-1]))).all()
    if is_sorted and int(ray[-1]) * n_groups < 2**62:
        return np.argsort(ray * n_groups + group, kind="stable")
    return np.lexsort((t, group, ray))


def merged(
    crossing: IntArray, t: FloatArray, t_out: FloatArray, distance: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the hit that begins each crossing, where its last hit ends, and its least distance.

    Crossings stand in the order of their first hits in the list, which may be sorted by distance.
    """
    n = int(crossing.max(initial=-1)) + 1
    ends, least, earliest = (np.full(n, value, np.float32) for value in (-np.inf, np.inf, np.inf))
    np.maximum.at(ends, crossing, t_out)
    np.minimum.at(least, crossing, distance)
    np.minimum.at(earliest, crossing, t)
    first, begin = np.full(n, len(crossing)), np.full(n, len(crossing))
    np.minimum.at(first, crossing, np.arange(len(crossing)))
    begins = np.flatnonzero(t == earliest[crossing])
    np.minimum.at(begin, crossing[begins], begins)
    order = np.argsort(first)
    return begin[order], ends[order], least[order]
