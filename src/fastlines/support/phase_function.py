"""The phase function of Henyey and Greenstein (1941): the directions into which a medium scatters light."""

from __future__ import annotations

import numpy as np

from .counter_random import Float64Array


def phase_function(g: float, cosine: Float64Array) -> Float64Array:
    """Return the density of directions, per solid angle, at cosines of the angle of scattering; 1 is straight on.

    Parameters
    ----------
    g : float
        The mean cosine, above -1 and below 1.
    cosine : float64 array

    Examples
    --------
    >>> (4 * np.pi * phase_function(0.5, np.array([-1.0, 1.0]))).round(6).tolist()
    [0.222222, 6.0]
    """
    return np.asarray((1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cosine) ** 1.5))


def scattering_cosine(g: float, xi: Float64Array) -> Float64Array:
    """Return random cosines of angles of scattering, distributed by the phase function.

    The distribution, inverted at a uniform ξ (Witt 1977; Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th
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
