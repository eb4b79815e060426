"""Arrays of NumPy as arrays of Mitsuba, and back."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..beams.coefficients import BoolArray
from ..support.counter_random import Float64Array, UInt64Array, uniform
from ..support.vectors import dot
from .packages import mi

#: The largest float32 below 1.
BELOW_ONE = 1 - 2.0**-24


def points(values: npt.ArrayLike) -> Any:
    """Return (n, 3) numbers as points of Mitsuba."""
    return mi.Point3f(_columns(values))


def vectors(values: npt.ArrayLike) -> Any:
    """Return (n, 3) numbers as vectors of Mitsuba."""
    return mi.Vector3f(_columns(values))


def colours(values: npt.ArrayLike) -> Any:
    """Return (n, 3) numbers as colours of Mitsuba."""
    return mi.Color3f(_columns(values))


def samples(keys: UInt64Array, draw: int) -> Any:
    """Return random numbers in [0, 1) as floats of Mitsuba, (n,)."""
    return mi.Float(np.minimum(uniform(keys, draw), BELOW_ONE).astype(np.float32))


def pairs_of_samples(keys: UInt64Array, draw: int) -> Any:
    """Return two random numbers in [0, 1) for each key as points of Mitsuba, (n,)."""
    return mi.Point2f(samples(keys, draw), samples(keys, draw + 1))


def triples(values: Any, n: int) -> Float64Array:
    """Return vectors or colours of Mitsuba as (n, 3) float64; one of them, or one channel, stands for all."""
    return np.ascontiguousarray(np.broadcast_to(np.array(values, np.float64), (3, n)).T)


def unit_triples(values: Any, n: int) -> Float64Array:
    """Return vectors of Mitsuba as (n, 3) float64 at length one."""
    found = triples(values, n)
    return np.asarray(found / np.sqrt(dot(found, found))[:, None])


def numbers(values: Any, n: int) -> Float64Array:
    """Return floats of Mitsuba as (n,) float64; one stands for all."""
    return np.broadcast_to(np.array(values, np.float64), n)


def flags(mask: Any, n: int) -> BoolArray:
    """Return a mask of Mitsuba as (n,) bool; one stands for all."""
    return np.broadcast_to(np.array(mask, np.bool_), n)


def _columns(values: npt.ArrayLike) -> Any:
    return np.ascontiguousarray(np.asarray(values, np.float32).T)
