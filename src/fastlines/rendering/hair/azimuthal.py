"""Azimuthal scattering: the direction around the fibre in which each lobe leaves it, spread by a trimmed logistic.

A ray that enters a circle at the angle γo from its normal, and travels inside at the angle γt, leaves after p passes
turned by Φ_p = 2pγt - 2γo + pπ. Chiang et al. 2016 (§4.1) spread Φ_p by the logistic distribution of scale s, trimmed
to -π…π and normalised, because unlike a Gaussian it has a cumulative distribution in closed form.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import AnyArray


def exit_azimuth(p: AnyArray | int, gamma_o: AnyArray, gamma_t: AnyArray) -> AnyArray:
    """Return Φ_p, the azimuth of the perfect direction after p passes through the fibre, in radians.

    Examples
    --------
    >>> exit_azimuth(0, np.float64(0.25), np.float64(0.1)).tolist()  # reflection
    -0.5
    """
    return np.asarray(2.0 * p * gamma_t - 2.0 * gamma_o + p * math.pi)


def trimmed_logistic(x: AnyArray, scale: float) -> AnyArray:
    """Return the density of the trimmed logistic distribution, at angles of any turn.

    Examples
    --------
    >>> angles = np.linspace(-np.pi, np.pi, 2000, endpoint=False)
    >>> round(float(trimmed_logistic(angles, 0.1).mean() * 2 * np.pi), 6)
    1.0
    """
    turned = np.abs(x - 2.0 * math.pi * np.rint(x * (0.5 / math.pi)))
    fall = np.exp(turned * (-1.0 / scale))
    return np.asarray(fall / ((1.0 + fall) ** 2 * (scale * _trimmed_mass(scale))))


def sample_trimmed_logistic(u: AnyArray, scale: float) -> AnyArray:
    """Return the angles, from -π to π, below which is the share u of the trimmed logistic distribution.

    Examples
    --------
    >>> sample_trimmed_logistic(np.array([0.0, 0.5, 1.0]), 0.5).round(6).tolist()
    [-3.141593, 0.0, 3.141593]
    """
    mass = _trimmed_mass(scale)
    share = 0.5 + (u - 0.5) * mass
    with np.errstate(divide="ignore"):
        angle = scale * (np.log(share) - np.log1p(-share))
    return np.clip(angle, -math.pi, math.pi)


def _trimmed_mass(scale: float) -> float:
    """Return how much of the logistic distribution is in -π…π."""
    return math.tanh(0.5 * math.pi / scale)
