"""Colours of hair as absorption coefficients, in units of one over the fibre's radius, for linear RGB.

The absorption of pigments is that of d'Eon et al. 2011, "An Energy-Conserving Hair Reflectance Model", table 1. The fit
of a reflectance is from Chiang et al. 2016, "A Practical and Controllable Hair and Fur Model for Production Path
Tracing", §4.2. The amount of melanin from 0 to 1 is that of Blender's node *Principled Hair BSDF*.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TypeAlias

from ...arrays import number
from ...errors import InputError

Rgb: TypeAlias = tuple[float, float, float]

#: The absorption of a unit of each pigment: eumelanin is brown to black, pheomelanin is red to yellow.
EUMELANIN: Rgb = (0.419, 0.697, 1.37)
PHEOMELANIN: Rgb = (0.187, 0.4, 1.05)

#: The least light that the darkest hair lets through, in `concentrations`: hair of melanin 1 is black, not opaque.
LEAST_LIGHT = 1e-4


def three(values: object, name: str) -> tuple[object, object, object]:
    """Return the three values of a colour, which may be in an array."""
    found = tuple(values) if isinstance(values, Iterable) else ()
    if len(found) != 3:
        raise InputError(f"{name}={values!r}; expected three numbers, for red, green and blue")
    return found


def absorption_of_pigments(eumelanin: float, pheomelanin: float = 0.0) -> Rgb:
    """Return the absorption coefficients of two concentrations of pigments.

    Parameters
    ----------
    eumelanin, pheomelanin : float
        Concentrations, at least 0. Eumelanin is about 0.3 in blond, 1.3 in brown and 8 in black hair.

    Examples
    --------
    >>> absorption_of_pigments(1.0)
    (0.419, 0.697, 1.37)
    """
    brown = number("eumelanin", eumelanin, "a concentration: a number, at least 0", 0.0)
    red = number("pheomelanin", pheomelanin, "a concentration: a number, at least 0", 0.0)
    r, g, b = (brown * dark + red * light for dark, light in zip(EUMELANIN, PHEOMELANIN, strict=True))
    return r, g, b


def concentrations(melanin: float, redness: float = 0.0) -> tuple[float, float]:
    """Return concentrations of eumelanin and pheomelanin: -ln(1 - melanin), split by redness.

    Parameters
    ----------
    melanin : float
        The darkness that is perceived, from 0, white, to 1, black.
    redness : float
        The share of pheomelanin, from 0, brown, to 1, red.

    Examples
    --------
    >>> [round(amount, 3) for amount in concentrations(0.6, redness=0.25)]
    [0.687, 0.229]
    """
    dark = number("melanin", melanin, "the amount of melanin: a number from 0 to 1", 0.0, 1.0)
    red = number("redness", redness, "the share of red pigment: a number from 0 to 1", 0.0, 1.0)
    amount = -math.log(max(1.0 - dark, LEAST_LIGHT))
    return amount * (1.0 - red), amount * red


def absorption_of_reflectance(reflectance: Rgb, azimuthal_roughness: float) -> Rgb:
    """Return the absorption coefficients with which dense hair has about this colour after all scattering.

    Parameters
    ----------
    reflectance : tuple of three floats
        Linear RGB, each above 0, at most 1. Black has no absorption; use 0.001 for it.
    azimuthal_roughness : float
        That of the material, from 0 to 1.

    Examples
    --------
    >>> [round(sigma, 4) for sigma in absorption_of_reflectance((1.0, 0.5, 0.1), 0.3)]
    [0.0, 0.0139, 0.1529]
    """
    expected = "a reflectance: three numbers, each above 0, at most 1"
    red, green, blue = (
        number("reflectance", each, expected, math.ulp(0.0), 1.0) for each in three(reflectance, "reflectance")
    )
    beta = number("azimuthal_roughness", azimuthal_roughness, "a number from 0 to 1", 0.0, 1.0)
    fit = 5.969 - 0.215 * beta + 2.532 * beta**2 - 10.73 * beta**3 + 5.574 * beta**4 + 0.245 * beta**5
    return (math.log(red) / fit) ** 2, (math.log(green) / fit) ** 2, (math.log(blue) / fit) ** 2
