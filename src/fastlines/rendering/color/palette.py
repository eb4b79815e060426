"""Colours: of directions, of strands, and maps from numbers to colours."""

from __future__ import annotations

import colorsys
import re
from collections.abc import Mapping
from functools import cache

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray, did_you_mean
from ...camera import Vector
from ...errors import InputError
from .tone import linear

#: Colours of a map at even steps, as sRGB in hexadecimal. The maps of matplotlib are in the public domain (CC0). Those
#: that begin with black lack the fifth below, and gray begins with a dark grey: black lines are invisible on the dark.
MAPS: Mapping[str, str] = {
    "viridis": "440154 482475 414487 355f8d 2a788e 21918c 22a884 44bf70 7ad151 bddf26 fde725",
    "magma": "3b0f70 641a80 8c2981 b73779 de4968 f7705c fe9f6d fecf92 fcfdbf",
    "inferno": "420a68 6a176e 932667 bc3754 dd513a f37819 fca50a f6d746 fcffa4",
    "coolwarm": "3b4cc0 5977e3 7b9ff9 9ebeff c0d4f5 dddcdc f2cbb7 f7ac8e ee8468 d65244 b40426",
    "gray": "404040 ffffff",
}
#: Colours of the types of an SWC file: undefined, soma, axon, basal and apical dendrites, and three of one's own.
NEURITES = "c4a878 55555c 3f7cbf cf5448 9460b8 56a06c d68f3e 5fb0b8"
#: The golden ratio's fraction, by which hues are spread.
GOLDEN = (5**0.5 - 1) / 2


def mapped(values: npt.NDArray[np.floating], name: str = "viridis") -> FloatArray:
    """Return the colour of numbers from 0 to 1, linear, (…, 3) float32; NaN is grey.

    Examples
    --------
    >>> mapped(np.array([1.0, np.nan]), "gray").round(1).tolist() == [[1.0, 1.0, 1.0], [np.float32(0.3)] * 3]
    True
    """
    check_map(name)
    table = np.array([hexadecimal(f"#{text}") for text in MAPS[name].split()])
    place = np.clip(np.nan_to_num(values, nan=0.5), 0, 1)
    steps = np.linspace(0, 1, len(table))
    colors = np.stack([np.interp(place, steps, table[:, axis]) for axis in range(3)], axis=-1)
    return np.where(np.isnan(values)[..., None], np.float32(0.3), colors).astype(np.float32)


def of_neurites(types: npt.NDArray[np.floating]) -> FloatArray:
    """Return the colours of types of an SWC file, as tools for neurons have them; (n, 3) linear.

    Examples
    --------
    >>> blue = of_neurites(np.array([2.0]))[0]  # an axon
    >>> bool(blue[2] > blue[0])
    True
    """
    table = np.array([hexadecimal(f"#{text}") for text in NEURITES.split()], np.float32)
    return np.asarray(table[np.clip(np.nan_to_num(types), 0, len(table) - 1).round().astype(np.int64)])


def check_map(name: str) -> None:
    """Refuse an unknown colour map."""
    if not isinstance(name, str) or name not in MAPS:
        raise InputError(f"there is no colour map {name!r}{did_you_mean(name, tuple(MAPS))}")


def hexadecimal(text: str) -> Vector:
    """Return the linear light of a colour such as "#c08040" or "#fff".

    Examples
    --------
    >>> hexadecimal("#fff"), hexadecimal("#000000")
    ((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    """
    digits = text.removeprefix("#")
    digits = "".join(2 * digit for digit in digits) if len(digits) == 3 else digits
    if not re.fullmatch("[0-9a-fA-F]{6}", digits):
        raise InputError(f"{text!r} is not a colour; expected # and six hexadecimal digits, such as #c08040")
    red, green, blue = linear([int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4)]).tolist()
    return red, green, blue


def light_of(color: object) -> Vector | None:
    """Return the linear light of "#rrggbb" or of three numbers from 0 to 1, as a screen shows them; None for a word.

    Examples
    --------
    >>> light_of("#fff"), light_of((1, 1, 1.0)), light_of("blond")
    ((1.0, 1.0, 1.0), (1.0, 1.0, 1.0), None)
    """
    if isinstance(color, str):
        return hexadecimal(color) if color.startswith("#") else None
    try:
        values = np.asarray(color, np.float64)
    except (TypeError, ValueError, OverflowError):
        values = np.empty(0)
    if values.shape != (3,) or not ((values >= 0) & (values <= 1)).all():
        raise InputError(f"color={color!r}; expected the name of a colour, '#rrggbb', or three numbers from 0 to 1")
    red, green, blue = linear(values).tolist()
    return red, green, blue


def of_directions(tangents: FloatArray) -> FloatArray:
    """Return colours by direction, as is usual for tracts: x is red, y is green, z is blue; (n, 3) linear."""
    parts = np.abs(tangents)
    return linear(0.22 + 0.74 * parts / np.maximum(parts.max(axis=1, keepdims=True), 1e-9) ** 0.6)


def of_numbers(numbers: IntArray) -> FloatArray:
    """Return a colour for each number, far from those of its neighbours; (n, 3) linear.

    Examples
    --------
    >>> len(np.unique(of_numbers(np.arange(100)), axis=0))
    100
    """
    hues, circle = _color_circle()
    place = (numbers * GOLDEN) % 1.0
    bright = 0.7 + 0.3 * ((numbers * GOLDEN**2) % 1.0)
    colors = np.stack([np.interp(place, hues, circle[:, axis], period=1.0) for axis in range(3)], axis=-1)
    return np.asarray(colors * bright[:, None], np.float32)


@cache
def _color_circle() -> tuple[npt.NDArray[np.float64], FloatArray]:
    """Return some hues from 0 to 1, and their colours."""
    hues = np.linspace(0, 1, 512, endpoint=False)
    return hues, linear([colorsys.hls_to_rgb(hue, 0.6, 0.72) for hue in hues])
