"""Random unit vectors, made of uniform random numbers in [0, 1)."""

from __future__ import annotations

import numpy as np

from .counter_random import Float64Array
from .vectors import dot


def isotropic(u: Float64Array, v: Float64Array) -> Float64Array:
    """Return directions of which none is preferred, (n, 3).

    Examples
    --------
    >>> isotropic(np.array([1.0, 0.5]), np.array([0.0, 0.0])).tolist()
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    """
    z, azimuth = 2 * u - 1, 2 * np.pi * v
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), z], axis=1)


def turned(direction: Float64Array, cosine: Float64Array, turn: Float64Array) -> Float64Array:
    """Return unit vectors at angles to unit vectors (n, 3), given by their cosines; `turn`, in [0, 1), is the azimuth.

    Examples
    --------
    >>> turned(np.array([[0.0, 0.0, 1.0]]), np.array([0.0]), np.array([0.0])).tolist()
    [[1.0, 0.0, 0.0]]
    """
    sine = np.sqrt(np.maximum(0, 1 - cosine * cosine))
    azimuth = 2 * np.pi * turn
    across, over = sine * np.cos(azimuth), sine * np.sin(azimuth)

    # Two axes across the direction (Duff et al. 2017, "Building an orthonormal basis, revisited").
    x, y, z = direction.T
    sign = np.copysign(1.0, z)
    a = -1 / (sign + z)
    b = x * y * a
    vectors = np.stack(
        [
            across * (1 + sign * x * x * a) + over * b + cosine * x,
            across * sign * b + over * (sign + y * y * a) + cosine * y,
            -across * sign * x - over * y + cosine * z,
        ],
        axis=1,
    )
    return np.asarray(vectors / np.sqrt(dot(vectors, vectors))[:, None])
