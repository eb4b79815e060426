"""Pictures as text: two pixels a character in colour, or shades of plain characters."""

from __future__ import annotations

import os
import sys
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt

#: From dark to light.
SHADES = " .:-=+*#%@"
#: The upper half of a character cell, which the foreground colours; the background colours the lower one.
HALF = "▀"


def has_colours(stream: Any = None) -> bool:
    """Return whether a stream, stdout by default, is a terminal that shows 24-bit colours, if NO_COLOR is not set."""
    stream = sys.stdout if stream is None else stream
    if not stream.isatty() or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    try:
        HALF.encode(stream.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def picture_text(picture: npt.NDArray[np.uint8], colours: bool) -> str:
    """Write a picture, (2 rows, columns) uint8, as lines of text: one for every two rows.

    Examples
    --------
    >>> print(picture_text(np.array([[0, 99, 255], [0, 99, 255]], np.uint8), colours=False))
     -@
    """
    upper, lower = picture[0::2], picture[1::2]
    if not colours:
        mean = (upper.astype(np.int64) + lower) // 2
        return "\n".join("".join(SHADES[value * len(SHADES) // 256] for value in row).rstrip() for row in mean.tolist())
    lines = []
    for pairs in np.stack([upper, lower], axis=2).tolist():
        runs = [(pair, len(list(run))) for pair, run in groupby(map(tuple, pairs))]
        cells = [f"\x1b[38;2;{a};{a};{a}m\x1b[48;2;{b};{b};{b}m{HALF * n}" for (a, b), n in runs]
        lines.append("".join(cells) + "\x1b[0m")
    return "\n".join(lines)
