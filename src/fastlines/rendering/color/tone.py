"""From light to the bytes of a picture: exposure, a filmic curve, and the sRGB encoding.

The curve is a rational function: dark and middle light keep their contrast, and only light above 10 becomes white.
Bright colours lose some of their saturation, as on film. The figures are those of K.
Narkowicz's fit to the Academy's reference curve ("ACES Filmic Tone Mapping Curve", 2016).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray
from ..sampling.sobol import hashed

#: How much light of a bright channel goes over into the others.
BLEED = 0.06


def filmic(light: AnyArray) -> FloatArray:
    """Bring light from [0, ∞) to [0, 1], in linear units of the screen.

    Examples
    --------
    >>> print(filmic(np.array([0.0, 0.18, 1.0, 4.0])).round(2))
    [0.   0.14 0.67 0.93]
    """
    x = 0.6 * np.maximum(light, 0)
    return np.asarray(np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1), np.float32)


def bleed(light: AnyArray) -> FloatArray:
    """Mix a little of each channel into the others, so that very bright colours become white."""
    mean = light.mean(axis=-1, keepdims=True)
    return np.asarray(light + np.float32(BLEED) * (mean - light), np.float32)


def srgb(screen: AnyArray) -> AnyArray:
    """Encode linear light of a screen, 0 to 1, by the curve of sRGB (IEC 61966-2-1)."""
    screen = np.clip(screen, 0, 1)
    return np.where(screen <= 0.0031308, 12.92 * screen, 1.055 * screen ** (1 / 2.4) - 0.055)


def linear(encoded: npt.ArrayLike) -> FloatArray:
    """Decode values of sRGB, 0 to 1, to linear light.

    Examples
    --------
    >>> linear([0.0, 0.5, 1.0]).round(3).tolist()
    [0.0, 0.21400000154972076, 1.0]
    """
    encoded = np.asarray(encoded, np.float32)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(np.float32)


def to_bytes(screen: AnyArray, rounding: AnyArray | float = 0.5) -> npt.NDArray[np.uint8]:
    """Turn encoded values, 0 to 1, into bytes."""
    return np.asarray(np.clip(np.clip(screen, 0, 1) * 255 + rounding, 0, 255)).astype(np.uint8)


def dithered(screen: AnyArray) -> npt.NDArray[np.uint8]:
    """Turn encoded values of pixels, (height, width, channels), into bytes, with noise instead of steps in gradients.

    Examples
    --------
    >>> dithered(np.full((100, 100, 1), 0.501)).mean().round(1)
    np.float64(127.8)
    """
    height, width = screen.shape[:2]
    pixels = np.arange(height * width, dtype=np.uint32).reshape(height, width, 1)
    return to_bytes(screen, hashed(pixels) * np.float32(2.0**-32))
