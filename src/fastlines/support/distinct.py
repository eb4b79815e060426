"""Distinct whole numbers, and which numbers are among others.

`numpy.unique` without indices, and so `numpy.isin`, hash numbers in C++ since NumPy 2.3, without the GIL. If Python
ends a daemon thread there, the process aborts ("terminate called"). These sort instead.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

_Number = TypeVar("_Number", bound=np.generic)


def distinct(numbers: npt.NDArray[_Number]) -> npt.NDArray[_Number]:
    """Return the distinct ones of some numbers, rising.

    Examples
    --------
    >>> distinct(np.array([3, 1, 3]))
    array([1, 3])
    """
    rising = np.sort(numbers, axis=None)
    is_new = np.ones(len(rising), np.bool_)
    is_new[1:] = rising[1:] != rising[:-1]
    return rising[is_new]


def is_among(numbers: npt.NDArray[Any], known: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Return which numbers are among the known ones.

    Examples
    --------
    >>> is_among(np.array([[3, 1], [2, 3]]), np.array([3, 5]))
    array([[ True, False],
           [False,  True]])
    """
    if not known.size:
        return np.zeros(numbers.shape, np.bool_)
    rising = np.sort(known, axis=None)
    return np.asarray(rising[np.minimum(np.searchsorted(rising, numbers), len(rising) - 1)] == numbers)
