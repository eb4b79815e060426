"""Arithmetic of many vectors.

Columns are summed, because NumPy is slow along an axis of three. The last bit does not depend on the machine, unlike
that of a BLAS product (`@`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

#: The squares of larger numbers, and of smaller ones than its reciprocal, are not safe in float32.
FAR = 1e15


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


def is_point(low: npt.NDArray[Any], high: npt.NDArray[Any]) -> bool:
    """Return whether float32 cannot distinguish a box from a single point, so that it has no size in a picture.

    Examples
    --------
    >>> is_point(np.zeros(3), np.array([0, 0, 1e-9])), is_point(np.full(3, 1e3), np.full(3, 1e3 + 1e-6))
    (False, True)
    """
    return bool((high - low).max() <= 1e-7 * np.abs(low + (high - low) / 2).max())


def unit(vectors: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Return vectors at length one, as float32; zero where they are zero.

    Examples
    --------
    >>> unit(np.float32([[0, 3e29, 4e29], [0, 0, 0]])).tolist()
    [[0.0, 0.6000000238418579, 0.800000011920929], [0.0, 0.0, 0.0]]
    """
    largest = np.abs(vectors).max(initial=0)
    if largest > FAR or 0 < largest < 1 / FAR:  # the squares would over- or underflow
        scale = np.abs(vectors).max(axis=-1, keepdims=True)
        vectors = np.divide(vectors, scale, out=np.zeros_like(vectors), where=scale > 0)
    length = np.sqrt(dot(vectors, vectors))
    return np.asarray(vectors * (1 / np.maximum(length, 1e-30))[:, None], np.float32)


def across(
    axes: npt.NDArray[Any], vectors: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[np.float32]]:
    """Return the sine and cosine of the angle between vectors and the planes across unit axes, and their unit parts.

    Examples
    --------
    >>> across(np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.6, 0.8]]))
    (array([0.8]), array([0.6]), array([[0., 1., 0.]], dtype=float32))
    """
    sine = np.clip(dot(vectors, axes), -1, 1)
    part = vectors - sine[:, None] * axes
    return sine, np.sqrt(np.maximum(1 - sine**2, 0)), unit(part)
