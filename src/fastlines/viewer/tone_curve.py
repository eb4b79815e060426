"""The inverse of the tone curve of the page, so that colours there are those of the legend.

The page shows light x as a(x) = RRTODT(M_in·x / 0.6), M_out (S. Hill's fit to the Academy's curve, as three.js has it).
A colour c is shown if its light is a⁻¹(c), where the rational function needs the root of a quadratic equation.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray

_IN = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
_OUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
_EXPOSURE = 1 / 0.6


def light_for(colors: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Return the bytes of light that the page shows as these colours, both (…, 3), linear from 0 to 1.

    Light above 1 cannot be given, so the brightest colours are a little darker.

    Examples
    --------
    >>> light_for([[0.0, 0.0, 0.0], [0.2, 0.2, 0.2], [1.0, 1.0, 1.0]])[:, 0]
    array([  0,  44, 255], dtype=uint8)
    """
    fitted = np.asarray(colors, np.float64) @ np.linalg.inv(_OUT).T
    y = np.clip(fitted, 0, 0.98)
    # y = (v² + 0.0245786 v − 0.000090537) / (0.983729 v² + 0.432951 v + 0.238081)
    a, b, c = 1 - 0.983729 * y, 0.0245786 - 0.432951 * y, -0.000090537 - 0.238081 * y
    v = (-b + np.sqrt(b * b - 4 * a * c)) / (2 * a)
    light = v @ np.linalg.inv(_IN).T / _EXPOSURE
    return np.asarray(np.rint(255 * np.clip(light, 0, 1)), np.uint8)


def shown_for(light: npt.NDArray[np.uint8]) -> FloatArray:
    """Return the colours that the page shows for bytes of light, linear, (…, 3) float32."""
    v = light / 255 @ _IN.T * _EXPOSURE
    y = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    return np.asarray(np.clip(y @ _OUT.T, 0, 1), np.float32)
