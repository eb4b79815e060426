"""Random numbers that are computed from a key and a counter, so that no order of work changes them.

Output number n of SplitMix64 for the seed s is a hash of s + (n + 1)·γ (Steele, Lea, Flood, "Fast Splittable
Pseudorandom Number Generators", 2014). An output may be the key of a stream of its own.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

UInt64Array: TypeAlias = npt.NDArray[np.uint64]
Float64Array: TypeAlias = npt.NDArray[np.float64]

GAMMA = np.uint64(0x9E3779B97F4A7C15)


def random_bits(keys: npt.ArrayLike, draw: int | npt.ArrayLike) -> UInt64Array:
    """Return output number `draw` for each key, which broadcast, as uint64.

    Examples
    --------
    >>> [hex(bits) for bits in random_bits(0, [0, 1])]
    ['0xe220a8397b1dcdaf', '0x6e789e6aa1b965f4']
    """
    counter = np.atleast_1d(np.asarray(draw, np.uint64)) + np.uint64(1)
    z = np.asarray(keys, np.uint64) + counter * GAMMA
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(z ^ (z >> np.uint64(31)), np.uint64)


def uniform(keys: npt.ArrayLike, draw: int | npt.ArrayLike) -> Float64Array:
    """Return random numbers in [0, 1), those of `random_bits`.

    Examples
    --------
    >>> uniform(0, [0, 1]).round(4).tolist()
    [0.8833, 0.4315]
    """
    return np.asarray((random_bits(keys, draw) >> np.uint64(11)) * 2.0**-53)
