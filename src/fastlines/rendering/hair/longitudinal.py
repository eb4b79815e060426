"""Longitudinal scattering: the density M_p of the inclination of light that leaves a fibre.

d'Eon et al. 2011 ("An Energy-Conserving Hair Reflectance Model", eq. 7) spread the perfect direction by a von
Mises-Fisher distribution of variance v on the sphere:

    M(θi, θo) = exp(-sin θi sin θo / v) I0(cos θi cos θo / v) / (2 v sinh(1 / v))

Its integral over sin θi from -1 to 1 is exactly 1, so that no energy is lost at grazing angles. For a small v each
factor overflows. With I0e(x) = exp(-x) I0(x), all exponents are one:

    M(θi, θo) = exp(-((cos θi - cos θo)² + (sin θi + sin θo)²) / 2v) I0e(cos θi cos θo / v) / (v (1 - exp(-2 / v)))

It is at most 0, and small differences are not cancelled.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import AnyArray

#: The polynomials of Abramowitz and Stegun, "Handbook of Mathematical Functions", 9.8.1 and 9.8.2: in (x / 3.75)² for
#: I0(x) up to 3.75, and in 3.75 / x for I0e(x) √x above. Their relative error is below 5e-7.
_SMALL = (1.0, 3.5156229, 3.0899424, 1.2067492, 0.2659732, 0.0360768, 0.0045813)
_LARGE = (
    0.39894228,
    0.01328592,
    0.00225319,
    -0.00157565,
    0.00916281,
    -0.02057706,
    0.02635537,
    -0.01647633,
    0.00392377,
)
_BORDER = 3.75


def scaled_i0(x: AnyArray) -> AnyArray:
    """Return exp(-x) I0(x), where I0 is the modified Bessel function, for floats x of at least 0.

    Examples
    --------
    >>> scaled_i0(np.array([0.0, 1.0, 100.0])).round(5).tolist()
    [1.0, 0.46576, 0.03994]
    """
    low = np.minimum(x, _BORDER)
    high = np.maximum(x, _BORDER)
    small = _horner(_SMALL, (low / _BORDER) ** 2) * np.exp(-low)
    large = _horner(_LARGE, _BORDER / high) / np.sqrt(high)
    return np.where(x < _BORDER, small, large)


def longitudinal(sin_i: AnyArray, cos_i: AnyArray, sin_o: AnyArray, cos_o: AnyArray, variance: float) -> AnyArray:
    """Return M(θi, θo), the density of sin θi.

    Parameters
    ----------
    sin_i, cos_i, sin_o, cos_o : arrays of floats
        Sines and cosines of the inclinations of both directions; cosines are at least 0.
    variance : float
        v, above 0.

    Examples
    --------
    >>> sine = (np.arange(2000) + 0.5) / 1000 - 1
    >>> density = longitudinal(sine, np.sqrt(1 - sine**2), np.float64(0.6), np.float64(0.8), 0.01)
    >>> round(float(density.mean() * 2), 3), round(float(sine[density.argmax()]), 2)
    (1.0, -0.6)
    """
    away = (cos_i - cos_o) ** 2 + (sin_i + sin_o) ** 2
    scale = 1.0 / (variance * -math.expm1(-2.0 / variance))
    return np.asarray(np.exp(away * (-0.5 / variance)) * scaled_i0(cos_i * cos_o * (1.0 / variance)) * scale)


def sample_longitudinal(
    sin_o: AnyArray, cos_o: AnyArray, variance: AnyArray, u: AnyArray, u_around: AnyArray
) -> AnyArray:
    """Draw sin θi from M, given two uniform numbers from 0 to 1 each (d'Eon et al. 2013, "Importance Sampling…").

    Examples
    --------
    >>> u = np.array([0.5, 1.0])
    >>> sample_longitudinal(np.float64(0.6), np.float64(0.8), np.float64(1e-6), u, u).round(2).tolist()
    [-0.6, -0.6]
    """
    # Draw the angle from the mean direction; keep 1 - cos, which is small.
    mass = np.maximum(u + (1.0 - u) * np.exp(-2.0 / variance), np.finfo(u.dtype).tiny)
    fall = np.clip(-variance * np.log(mass), 0.0, 2.0)
    sine = np.sqrt(fall * (2.0 - fall))
    # Turn it to a random side, and measure its inclination.
    sin_i = (fall - 1.0) * sin_o + sine * np.cos(2.0 * math.pi * u_around) * cos_o
    return np.asarray(np.clip(sin_i, -1.0, 1.0))


def _horner(coefficients: tuple[float, ...], x: AnyArray) -> AnyArray:
    result = np.full_like(x, coefficients[-1])
    for each in coefficients[-2::-1]:
        result *= x
        result += each
    return result
