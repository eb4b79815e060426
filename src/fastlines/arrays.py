"""Arrays of numbers from whatever the user has: conversions, and errors that say what was given."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .immutable import frozen, own

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int64]

#: What to do with invalid rows.
INVALID = ("error", "skip")

FLOAT32_MAX = float(np.finfo(np.float32).max)


def list_rows(bad: npt.NDArray[np.bool_], shown: int = 5) -> str:
    """Name the rows of a mask for an error message: ``rows 3, 17 and 4 more``."""
    rows = np.flatnonzero(bad)
    text = ", ".join(str(row) for row in rows[:shown])
    more = f" and {len(rows) - shown} more" if len(rows) > shown else ""
    return f"{'row' if len(rows) == 1 else 'rows'} {text}{more}"


def to_float32(values: npt.ArrayLike, name: str) -> FloatArray:
    """Convert to float32, or say which argument is not made of numbers."""
    return _float32(values, name)[0]


def own_float32(values: npt.ArrayLike, name: str) -> FloatArray:
    """Convert to an immutable float32 array."""
    array, is_new = _float32(values, name)
    immutable: FloatArray = own(array) if is_new else frozen(array)
    return immutable


def _float32(values: npt.ArrayLike, name: str) -> tuple[FloatArray, bool]:
    """Convert to float32; tell whether the memory is new."""
    # The usual cases at once: a small batch has no time for more.
    if type(values) is np.ndarray and values.dtype == np.float32 and values.flags.c_contiguous:
        return values, False
    if type(values) is float and (abs(values) < FLOAT32_MAX or abs(values) == np.inf):
        return np.array(values, np.float32), True
    refuse_masked(values, name)
    try:
        with np.errstate(over="ignore"):
            given = np.asarray(values)
            if given.dtype.kind not in "fiub":
                raise TypeError(f"dtype {given.dtype}")
            array = np.asarray(given, np.float32, order="C")
    except (TypeError, ValueError) as error:
        why = "its parts differ in length" if "inhomogeneous" in str(error) else error
        raise InputError(f"{name}: {kind_of(values)} cannot be read as an array of numbers: {why}") from None
    return array, array is not given


def to_integers(values: npt.ArrayLike, name: str) -> IntArray:
    """Convert whole numbers to int64, or say which argument holds something else."""
    refuse_masked(values, name)
    array = np.asarray(values)
    if array.size and array.dtype.kind not in "iu":
        raise InputError(f"{name} have dtype {array.dtype}; expected whole numbers")
    if array.dtype.kind == "u" and array.size and int(array.max()) > np.iinfo(np.int64).max:
        raise InputError(f"{name} hold {array.max()}; expected whole numbers below 2^63")
    return array.astype(np.int64, copy=False)


def refuse_masked(values: object, name: str) -> None:
    """Refuse masked values, for which a tree has no place."""
    if np.ma.is_masked(values):
        raise InputError(f"{name} hold masked values; fill them, with NaN for example, or leave their rows out")


def column(values: npt.ArrayLike, name: str, n: int, of: str) -> npt.NDArray[Any]:
    """Take an array of one row for each of n things."""
    refuse_masked(values, name)
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{name} cannot be read as an array: {error}") from None
    if array.ndim == 0 or len(array) != n:
        raise InputError(f"{name} has shape {array.shape}; expected one row for each of {n} {of}")
    return array


def kind_of(values: object) -> str:
    """Describe what was given, for an error message."""
    if isinstance(values, np.ndarray):
        return f"an array of {values.dtype} of shape {values.shape}"
    return f"a {type(values).__name__}"
