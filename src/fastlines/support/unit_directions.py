"""Random unit vectors, made of uniform random numbers in [0, 1)."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .vectors import dot

Float64Array: TypeAlias = npt.NDArray[np.float64]


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


def scattering_cosine(g: float, xi: Float64Array) -> Float64Array:
    """Return cosines of angles of scattering, 1 straight on, by the phase function of Henyey and Greenstein (1941).

    Its distribution, inverted at a uniform ξ (Witt 1977; Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th
    ed., §11.3.1):

        cos θ = (1 + g² − ((1 − g²) / (1 − g + 2gξ))²) / 2g,     2ξ − 1 for g = 0.

    Examples
    --------
    >>> scattering_cosine(0.5, np.array([0.0, 1.0])), scattering_cosine(0.0, np.array([0.25]))
    (array([-1.,  1.]), array([-0.5]))
    """
    if abs(g) < 1e-4:
        return 2 * xi - 1
    return np.asarray((1 + g * g - ((1 - g * g) / (1 - g + 2 * g * xi)) ** 2) / (2 * g))


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
