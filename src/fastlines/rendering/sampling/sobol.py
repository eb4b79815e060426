"""Sample points: Owen-scrambled Sobol sequences, and points of a pixel distributed as the Blackman–Harris filter.

Each pixel has its own scrambling, so that the error of a picture is noise without structure. The first 2ᵏ samples of a
pixel are as evenly distributed as any 2ᵏ, so that a picture can stop early.

Sources: Burley, "Practical Hash-based Owen Scrambling", JCGT 2020; for drawing points from the filter, Ernst,
Stamminger and Greiner, "Filter Importance Sampling", 2006.

`uniforms` defines the numbers. `engine.sample_numbers` computes the same ones, compiled.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray, IntArray
from ...engines import engine

Words = npt.NDArray[np.uint32]

#: The radius of the filter in pixels.
FILTER_RADIUS = 1.5
#: The weights of the cosines of the Blackman–Harris window.
WINDOW = (0.35875, -0.48829, 0.14128, -0.01168)


def uniforms(index: int, seeds: Words, dimension: int) -> FloatArray:
    """Return one coordinate of sample `index` of the sequence of each seed.

    Parameters
    ----------
    index : int
        The number of the sample, which counts from 0.
    seeds : (n,) uint32
        As `hashed` makes them.
    dimension : int
        Dimensions 2j and 2j + 1 are a point of the plane; each such pair is shuffled anew.

    Returns
    -------
    (n,) float32
        In [0, 1).

    Examples
    --------
    >>> seeds = hashed(np.zeros(1, np.uint32))
    >>> sorted(int(4 * uniforms(i, seeds, 0)[0]) for i in range(4))  # one in each quarter
    [0, 1, 2, 3]
    """
    pair, axis = divmod(dimension, 2)
    seeds = hashed(seeds, pair)
    words = np.full(1, index, np.uint32)
    if pair:
        words = _scrambled(words, seeds)
    point = _sobol(words) if axis else _reversed(words)
    scrambled = _scrambled(point, hashed(seeds, 0x5BD1 + axis))
    return np.asarray((scrambled >> np.uint32(8)) * np.float32(2.0**-24))


def hashed(words: Words, salt: int = 0) -> Words:
    """Return well-mixed 32-bit words, other ones for another salt."""
    with np.errstate(over="ignore"):
        mixed = words + np.uint32((0x9E3779B9 * (salt + 1)) & 0xFFFFFFFF)
        mixed = (mixed ^ (mixed >> np.uint32(16))) * np.uint32(0x21F0AAAD)
        mixed = (mixed ^ (mixed >> np.uint32(15))) * np.uint32(0x735A2D97)
    return np.asarray(mixed ^ (mixed >> np.uint32(15)))


def filter_offset(uniform: FloatArray) -> FloatArray:
    """Return the place in a pixel, from its centre and in pixels, at which the filter's integral has these values.

    Examples
    --------
    >>> filter_offset(np.array([0.0, 0.5, 1.0])).round(3).tolist()
    [-1.5, 0.0, 1.5]
    """
    return engine.interpolated(np.ascontiguousarray(uniform, np.float32), *_filter_integral())


def points_in_pixels(index: int | None, pixels: IntArray, width: int) -> tuple[AnyArray, AnyArray]:
    """Return the point of the picture that a sample of each pixel has; without an index, the pixel's centre.

    Parameters
    ----------
    index : int or None
        The number of the sample, which counts from 0.
    pixels : (n,) array of int
        Row by row from the top left.
    width : int
        The width of the picture.

    Returns
    -------
    x, y : (n,) float64
        In pixels, as `Camera.ray` takes them.

    Examples
    --------
    >>> points_in_pixels(None, np.arange(3), width=2)
    (array([0.5, 1.5, 0.5]), array([0.5, 0.5, 1.5]))
    """
    x, y = pixels % width + 0.5, pixels // width + 0.5
    if index is None:
        return x, y
    right, down = engine.sample_numbers(index, hashed(pixels.astype(np.uint32)), 0, 2)
    return x + filter_offset(right), y + filter_offset(down)


@cache
def _filter_integral() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    x = np.linspace(0, 1, 513)
    waves = (weight * np.sin(2 * np.pi * k * x) / (2 * np.pi * k) for k, weight in enumerate(WINDOW) if k)
    integral = WINDOW[0] * x + sum(waves)
    return integral / integral[-1], (2 * x - 1) * FILTER_RADIUS


def _scrambled(words: Words, seeds: Words) -> Words:
    """Flip each bit of words by a function of its higher bits and the seed (Owen's nested uniform scrambling)."""
    with np.errstate(over="ignore"):
        words = _reversed(words)
        words = words ^ (words * np.uint32(0x3D20ADEA))
        words = words + seeds
        words = words * ((seeds >> np.uint32(16)) | np.uint32(1))
        words = words ^ (words * np.uint32(0x05526C56))
        return _reversed(words ^ (words * np.uint32(0x53A22864)))


def _reversed(words: Words) -> Words:
    """Reverse the bits of words: for an index, the first coordinate of the Sobol sequence."""
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF)):
        words = ((words >> np.uint32(shift)) & np.uint32(mask)) | ((words & np.uint32(mask)) << np.uint32(shift))
    return np.asarray((words >> np.uint32(16)) | (words << np.uint32(16)))


def _sobol(index: Words) -> Words:
    """Return the second coordinate of the Sobol sequence: the bits of the index times Pascal's triangle mod 2."""
    point, column = np.zeros_like(index), np.uint32(1 << 31)
    for bit in range(32):
        point ^= np.where(index >> np.uint32(bit) & np.uint32(1), column, np.uint32(0))
        column ^= column >> np.uint32(1)
    return point
