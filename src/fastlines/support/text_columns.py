"""Columns of texts as arrays of numbers, for files that hold no texts.

A column is the number of each text, int32. The different texts are the bytes of a list in JSON, in another array whose
name begins with ``texts/``.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import numpy.typing as npt

#: What the name of the array of different texts begins with; the name of the column follows.
TEXTS = "texts/"


def numbered(texts: npt.NDArray[Any]) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.uint8]]:
    """Return the number of each text, in the shape of the column, and the different texts as bytes.

    Examples
    --------
    >>> codes, data = numbered(np.array(["oak", "elm", "oak"]))
    >>> codes.tolist(), data.tobytes()
    ([0, 1, 0], b'["oak", "elm"]')
    """
    number: dict[str, int] = {}
    codes = [number.setdefault(text, len(number)) for text in texts.reshape(-1).tolist()]
    return np.array(codes, np.int32).reshape(texts.shape), np.frombuffer(json.dumps(list(number)).encode(), np.uint8)


def texts_of(codes: npt.NDArray[Any], data: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a column of texts, an array of objects; raise a ValueError or a TypeError if the arrays do not fit.

    Examples
    --------
    >>> texts_of(*numbered(np.array(["oak", "elm", "oak"]))).tolist()
    ['oak', 'elm', 'oak']
    """
    try:
        known = json.loads(data.tobytes())
    except RecursionError:
        known = None
    if not isinstance(known, list) or not all(isinstance(text, str) for text in known) or codes.dtype != np.int32:
        raise TypeError("its texts are no texts")
    if codes.size and not 0 <= codes.min() <= codes.max() < len(known):
        raise ValueError("its texts are fewer than their numbers say")
    return np.asarray(np.array([*known, None], object)[codes])
