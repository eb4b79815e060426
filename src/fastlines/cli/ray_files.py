"""Files of rays and of numbers, as ``fastlines query`` reads them."""

from __future__ import annotations

import re
import zipfile
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


def read_rays(path: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Read rays from a .npy or .npz file."""
    if not path.lower().endswith((".npy", ".npz")):
        raise InputError(f"{path}: rays are read from .npy, an array (n, 6), or .npz, with origins and directions")
    try:
        if path.lower().endswith(".npz"):
            with open(path, "rb") as file, np.load(file, allow_pickle=False) as arrays:
                missing = {"origins", "directions"} - set(arrays)
                if missing:
                    raise InputError(f"{path}: has no array {' and no '.join(sorted(missing))}; expected both")
                return arrays["origins"], arrays["directions"]
    except InputError:
        raise
    except (ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise _unread(path, "rays", error) from None
    loaded = load_array(path, "rays")
    if loaded.ndim != 2 or loaded.shape[1] != 6:
        raise InputError(f"{path}: has the shape {loaded.shape}; expected (n, 6): origin and direction of each ray")
    return np.asarray(loaded[:, :3]), np.asarray(loaded[:, 3:])


def load_array(path: str, what: str) -> npt.NDArray[Any]:
    """Map a .npy file into memory: NumPy then compares it with its header before it allocates memory."""
    try:
        return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))
    except (ValueError, EOFError) as error:
        raise _unread(path, what, error) from None


def _unread(path: str, what: str, error: Exception) -> InputError:
    """Say why a file cannot be read as an array."""
    why = "it holds Python objects, not numbers" if re.search("pickle|objects", str(error)) else error
    return InputError(f"{path}: cannot be read as an array of {what}: {why}")
