"""Crossings: hits of one ray and one strand or curve whose intervals from t to t_out overlap."""

from __future__ import annotations

import numpy as np

from .arrays import FloatArray, IntArray


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
    order = np.lexsort((t, group, ray))
    ray, group, t, t_out = ray[order], group[order], t[order], t_out[order]
    begins = np.ones(len(order), bool)
    begins[1:] = (ray[1:] != ray[:-1]) | (group[1:] != group[:-1])
    # Find the largest t_out up to each hit of its group, by ranks; those of later groups are larger.
    by_end = np.argsort(t_out, kind="stable")
    rank = np.empty_like(by_end)
    rank[by_end] = np.arange(len(by_end))
    number = np.cumsum(begins) - 1
    latest = t_out[by_end[np.maximum.accumulate(number * len(order) + rank) % len(order)]]
    # A hit that begins behind all hits before it begins a new crossing.
    begins[1:] |= t[1:] > latest[:-1]
    found = np.empty(len(order), np.int64)
    found[order] = np.cumsum(begins) - 1
    return found


def first_hits_of(crossing: IntArray, t_out: FloatArray | None) -> tuple[IntArray, FloatArray | None]:
    """Return the first hit of each crossing, in the order of the hits, and where the last hit of each ends."""
    first: IntArray = np.sort(np.unique(crossing, return_index=True)[1])
    if t_out is None:
        return first, None
    ends = np.full(int(crossing.max(initial=-1)) + 1, -np.inf, np.float32)
    np.maximum.at(ends, crossing, t_out)
    return first, ends[crossing[first]]
