"""Vectors at length one, for shading: many at a time, (n, 3) float32, and never NaN."""

from __future__ import annotations

import numpy as np

from ..arrays import AnyArray, FloatArray
from ..vectors import dot


def unit(vectors: AnyArray) -> FloatArray:
    """Return vectors at length one, as float32; zero where they are zero."""
    length = np.sqrt(dot(vectors, vectors))
    return np.asarray(vectors * (1 / np.maximum(length, 1e-30))[:, None], np.float32)


def across(axes: AnyArray, vectors: AnyArray) -> tuple[AnyArray, AnyArray, FloatArray]:
    """Return the sine and cosine of the angle between vectors and the planes across unit axes, and their unit parts.

    Examples
    --------
    >>> across(np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.6, 0.8]]))
    (array([0.8]), array([0.6]), array([[0., 1., 0.]], dtype=float32))
    """
    sine = np.clip(dot(vectors, axes), -1, 1)
    part = vectors - sine[:, None] * axes
    return sine, np.sqrt(np.maximum(1 - sine**2, 0)), unit(part)
