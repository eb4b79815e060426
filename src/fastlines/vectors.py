"""Arithmetic of many vectors.

Columns are summed, because NumPy is slow along an axis of three. The last bit does not depend on the machine, unlike
that of a BLAS product (`@`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def dot(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the inner products of vectors (…, 3) with vectors of that shape, or with one, (…).

    Examples
    --------
    >>> dot(np.array([[1.0, 2.0, 3.0]]), np.array([4.0, 5.0, 6.0])).tolist()
    [32.0]
    """
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def is_zero(vectors: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Return which vectors (…, 3) are zero, (…); NaN is not.

    Examples
    --------
    >>> is_zero(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])).tolist()
    [True, False]
    """
    return np.asarray((vectors[..., 0] == 0) & (vectors[..., 1] == 0) & (vectors[..., 2] == 0))
