"""Ranges of whole numbers, and first occurrences, of whole arrays at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def ranges(begin: npt.NDArray[np.integer], counts: npt.NDArray[np.integer]) -> npt.NDArray[np.int64]:
    """Return the numbers of several ranges, one after another.

    Examples
    --------
    >>> ranges(np.array([7, 0, 3]), np.array([2, 0, 3]))
    array([7, 8, 3, 4, 5])
    """
    before = np.cumsum(counts) - counts
    return np.asarray(np.repeat(begin - before, counts) + np.arange(int(counts.sum())))


def is_first(numbers: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Return whether each number, from 0 on, is there for the first time.

    Examples
    --------
    >>> is_first(np.array([3, 1, 3, 0]))
    array([ True,  True, False,  True])
    """
    places = np.arange(len(numbers))
    first = np.empty(int(numbers.max(initial=-1)) + 1, np.int64)
    first[numbers[::-1]] = places[::-1]  # of several places, the last assigned stays
    return np.asarray(first[numbers] == places)
