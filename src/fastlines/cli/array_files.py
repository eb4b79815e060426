"""Arrays from files of NumPy, and numbers from texts, as arguments of commands name them."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Collection
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import InputError


def numbers(text: str | None, name: str) -> npt.NDArray[Any] | None:
    """Read whole numbers separated by commas, or those of a .npy file."""
    if text is None:
        return None
    if text.lower().endswith(".npy"):
        return load_array(text, "numbers")
    try:
        return np.array([int(part) for part in text.split(",")])
    except (ValueError, OverflowError):
        raise InputError(f"{name} {text!r} is not whole numbers separated by commas, such as 3,17, or a .npy") from None


def load_array(path: str, what: str) -> npt.NDArray[Any]:
    """Map a .npy file into memory: NumPy then compares it with its header before it allocates memory."""
    try:
        return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))
    except (ValueError, EOFError) as error:
        raise _unread(path, what, error) from None


def load_arrays(path: str, what: str, names: Collection[str]) -> dict[str, npt.NDArray[Any]]:
    """Read those of some arrays that a .npz file has."""
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in names if name in arrays}
    except (ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise _unread(path, what, error) from None


def _unread(path: str, what: str, error: Exception) -> InputError:
    """Say why a file cannot be read as an array."""
    why = "it holds Python objects, not numbers" if re.search("pickle|objects", str(error)) else error
    return InputError(f"{path}: cannot be read as an array of {what}: {why}")
