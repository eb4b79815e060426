"""Checks of arguments, and their conversion to arrays; each error says what was given and what was expected."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import InputError, PrecisionWarning
from .support.immutable import frozen, own
from .support.texts import with_article
from .support.warn_caller import warn_caller

AnyArray: TypeAlias = npt.NDArray[Any]
FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int64]

#: What to do with invalid rows.
INVALID = ("error", "skip")

FLOAT32_MAX = float(np.finfo(np.float32).max)

#: Coordinates beyond this would overflow when squared in the arithmetic of the builders.
COORDINATE_LIMIT = 1e30

#: The numbers of strands are smaller, so that those of two containers can be counted on.
STRAND_LIMIT = 2**62

#: The rounding error of a coordinate that is worth a warning, as a fraction of the scene's longest side.
COARSE = 2.0**-18

#: The largest count that the core can take.
LARGEST = 2**63 - 1

#: The least number above 0.
LEAST = math.ulp(0.0)

#: The types of memory, as DLPack numbers them, that a GPU reads: its own, and managed memory.
_OF_A_GPU = (2, 13)


def count(name: str, value: object, least: int, most: int | None = None) -> int:
    """Check a whole number, which may be one of NumPy's."""
    given, end = value.item() if isinstance(value, np.integer) else value, LARGEST if most is None else most
    if isinstance(given, bool) or not isinstance(given, int) or not least <= given <= end:
        too_many = isinstance(given, int) and given > LARGEST
        upto = "or more" if most is None and not too_many else f"to {end}"
        raise InputError(f"{name}={value!r}; expected a whole number, {least} {upto}")
    return given


def byte_count(name: str, value: object) -> int:
    """Check an amount of memory."""
    try:
        return count(name, value, 0)
    except InputError:
        raise InputError(f"{name}={value!r}; expected a whole number of bytes, such as 4_000_000_000") from None


def number(name: str, value: object, expected: str, low: float, high: float = sys.float_info.max) -> float:
    """Check a number from `low` to `high`."""
    given = value.item() if isinstance(value, np.generic | np.ndarray) and value.ndim == 0 else value
    if isinstance(given, bool) or not isinstance(given, int | float) or not low <= given <= high:
        raise InputError(f"{name}={value!r}; expected {expected}")
    return float(given) + 0.0  # no negative zero


def instance(name: str, value: object, kind: type, expected: str) -> object:
    """Check the type of a value."""
    if not isinstance(value, kind):
        raise InputError(f"{name}={value!r}; expected {expected}")
    return value


def check_fields(made: object, names: Iterable[str], check: Callable[..., object], *bounds: object) -> None:
    """Check fields of a frozen dataclass, and keep what the check returns; None may stay where it is the default."""
    for name in names:
        value = getattr(made, name)
        if value is not None or getattr(type(made), name, ...) is not None:
            object.__setattr__(made, name, check(name, value, *bounds))


def sequence(name: str, value: object, kind: type | tuple[type, ...], expected: str) -> tuple[Any, ...]:
    """Check one thing or several of a kind."""
    several = (value,) if isinstance(value, kind) else value
    if not isinstance(several, Sequence) or not several or not all(isinstance(one, kind) for one in several):
        raise InputError(f"{name}={value!r}; expected {expected}")
    return tuple(several)


def choice(name: str, value: object, known: Iterable[str]) -> str:
    """Check that a value is one of a few words."""
    words = tuple(known)
    if not isinstance(value, str) or value not in words:
        raise InputError(f"{name}={value!r} is not a choice: use {' or '.join(map(repr, words))}")
    return value


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """End an error message about an unknown word."""
    import difflib  # only for an error: it takes longer to import than all checks

    words = tuple(known)
    close = difflib.get_close_matches(str(word).lower(), words, 1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"; {hint}known: {', '.join(words)}"


def list_rows(bad: npt.NDArray[np.bool_], shown: int = 5) -> str:
    """Name the rows of a mask for an error message: ``rows 3, 17 and 4 more``."""
    return name_rows(np.flatnonzero(bad), shown)


def name_rows(rows: IntArray, shown: int = 5) -> str:
    """Name rows as `list_rows` does."""
    text = ", ".join(str(row) for row in rows[:shown])
    more = f" and {len(rows) - shown} more" if len(rows) > shown else ""
    return f"{'row' if len(rows) == 1 else 'rows'} {text}{more}"


def to_float32(values: npt.ArrayLike, name: str) -> FloatArray:
    """Convert to float32, or say which argument is not made of numbers."""
    return _float32(values, name)[0]


def own_float32(values: npt.ArrayLike, name: str) -> FloatArray:
    """Convert to an immutable float32 array."""
    array, is_new = _float32(values, name)
    return np.asarray(own(array) if is_new else frozen(array))


def _float32(values: npt.ArrayLike, name: str) -> tuple[FloatArray, bool]:
    """Convert to float32, and return whether the memory is new."""
    # Return the usual cases at once: for a small batch the checks below would dominate.
    if type(values) is np.ndarray and values.dtype == np.float32 and values.flags.c_contiguous:
        return values, False
    if type(values) is float and (abs(values) < FLOAT32_MAX or abs(values) == np.inf):
        return np.array(values, np.float32), True
    given = _numbers(values, name)
    with np.errstate(over="ignore"):
        array = np.asarray(given, np.float32, order="C")
    return array, array is not given


def to_float64(values: npt.ArrayLike, name: str) -> npt.NDArray[np.float64]:
    """Convert to float64, or say which argument is not made of numbers."""
    return np.asarray(_numbers(values, name), np.float64, order="C")


def _numbers(values: npt.ArrayLike, name: str) -> AnyArray:
    """Convert to an array of numbers, or say which argument holds something else."""
    refuse_masked(values, name)
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "fiub":
            raise TypeError(f"dtype {given.dtype}")
    except (TypeError, ValueError) as error:
        why = "its parts differ in length" if "inhomogeneous" in str(error) else error
        raise InputError(f"{name}: {kind_of(values)} cannot be read as an array of numbers: {why}") from None
    return given


def to_integers(values: npt.ArrayLike, name: str) -> IntArray:
    """Convert whole numbers to int64, or say which argument holds something else."""
    refuse_masked(values, name)
    array = np.asarray(values)
    if array.size and array.dtype.kind not in "iu":
        raise InputError(f"{name} have dtype {array.dtype}; expected whole numbers")
    if array.dtype.kind == "u" and array.size and int(array.max()) > np.iinfo(np.int64).max:
        raise InputError(f"{name} hold {array.max()}; expected whole numbers below 2^63")
    return array.astype(np.int64, copy=False)


def to_strands(values: npt.ArrayLike) -> IntArray:
    """Convert the numbers of strands to int64; all below 0 become -1, which is no strand.

    Examples
    --------
    >>> to_strands([0, 7, -3])
    array([ 0,  7, -1])
    """
    strands = to_integers(values, "strands")
    if strands.size and strands.min() < -1:
        strands = np.maximum(strands, -1)
    check_strands(strands)
    return strands


def check_strands(strands: IntArray) -> None:
    """Refuse numbers that strands cannot have."""
    if strands.size and not -1 <= strands.min() <= strands.max() < STRAND_LIMIT:
        raise InputError(
            f"strands are from {strands.min()} to {strands.max()}; expected numbers from 0 to 2^62 - 1, or -1 for none"
        )


def is_on_device(array: Any) -> bool:
    """Return whether an array is in the memory of a GPU."""
    if isinstance(array, np.ndarray | list | tuple):  # single rays are in a hurry
        return False
    found = getattr(array, "__dlpack_device__", None)
    return found is not None and int(found()[0]) in _OF_A_GPU


def refuse_masked(values: object, name: str) -> None:
    """Refuse masked values, which a tree cannot represent; of a mapping, those of each array in it."""
    if isinstance(values, Mapping):
        for key, part in values.items():
            refuse_masked(part, str(key))
    elif np.ma.is_masked(values):
        raise InputError(f"{name} hold masked values; fill them, with NaN for example, or leave their rows out")


def column(values: npt.ArrayLike, name: str, n: int, of: str) -> npt.NDArray[Any]:
    """Convert to an array, and check that it has one row for each of n things."""
    refuse_masked(values, name)
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{name} cannot be read as an array: {error}") from None
    if array.ndim == 0 or len(array) != n:
        raise InputError(f"{name} has shape {array.shape}; expected one row for each of {n} {of}")
    return array


def neighbours(values: npt.NDArray[Any], sizes: IntArray) -> npt.NDArray[Any]:
    """Return both rows of each two that follow each other in runs of these sizes, as a new array (n, 2, …).

    No run is empty. A lone row is joined with itself.
    """
    if (is_alone := sizes == 1).any():
        values, sizes = np.repeat(values, np.repeat(is_alone + 1, sizes), axis=0), sizes + is_alone
    is_joined = np.ones(max(len(values), 1) - 1, np.bool_)
    is_joined[np.cumsum(sizes)[:-1] - 1] = False
    per_row = values.shape[1:]
    n_bytes = math.prod(per_row, start=values.dtype.itemsize)
    if values.dtype.hasobject or not n_bytes or not len(is_joined):
        return np.stack([values[:-1][is_joined], values[1:][is_joined]], axis=1)
    # View both rows as one item of bytes: NumPy copies a run of items that a mask selects at once.
    raw = np.ascontiguousarray(values).reshape(-1).view(np.uint8)
    pairs: npt.NDArray[Any] = np.ndarray((len(is_joined),), f"V{2 * n_bytes}", buffer=raw.data, strides=(n_bytes,))
    return pairs[is_joined].view(values.dtype).reshape(-1, 2, *per_row)


def box_of(points: FloatArray) -> FloatArray:
    """Return the box of points (n, 3) as (2, 3): lowest and highest corner; lowest > highest if there are none."""
    # Reduce one axis after the other: NumPy is many times slower along the long axis of a narrow array.
    axes = [points[:, axis] for axis in range(3)]
    low, high = [axis.min(initial=np.inf) for axis in axes], [axis.max(initial=-np.inf) for axis in axes]
    return np.array([low, high], np.float32)


def unusable(array: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which rows of corners (n, k, 3) hold NaN, Inf or too large a coordinate."""
    # Test the extremes first: mostly they show that all rows are valid. NaN propagates to both.
    if array.size and array.min() >= -COORDINATE_LIMIT and array.max() <= COORDINATE_LIMIT:
        return np.zeros(len(array), np.bool_)
    return ~np.asarray(np.abs(array).max(axis=(1, 2), initial=0) <= COORDINATE_LIMIT, np.bool_)


def refuse_rows(bad: npt.NDArray[np.bool_], name: str, advice: str = "") -> None:
    """Refuse rows that are `unusable`."""
    if bad.any():
        raise InputError(f"{unusable_text(np.flatnonzero(bad), f'{len(bad)} {name}')}{advice}")


def unusable_text(rows: IntArray, of: str) -> str:
    """Say which rows are `unusable`, of so many."""
    return f"{len(rows)} of {of} hold NaN, Inf or a coordinate beyond {COORDINATE_LIMIT:g} ({name_rows(rows)})"


def is_text(values: AnyArray) -> bool:
    """Return whether an array holds texts, as Python objects or as NumPy's own type."""
    return values.dtype.kind == "U" or (values.dtype == object and all(type(value) is str for value in values.flat))


def kind_of(values: object) -> str:
    """Describe a value that was given, for an error message."""
    if isinstance(values, np.ndarray):
        return f"an array of {values.dtype} of shape {values.shape}"
    if isinstance(values, type):
        return f"a class, {values.__name__}"
    return with_article(type(values).__name__)


def is_far(points: npt.NDArray[np.float32]) -> bool:
    """Return whether (n, 3) points may be so far from zero, for the size of their scene, that float32 is too coarse."""
    some = points[:: len(points) // 1024 + 1]
    some = some[np.abs(some).max(axis=1) <= COORDINATE_LIMIT]
    size = float((some.max(axis=0) - some.min(axis=0)).max()) if len(some) else 0.0
    far = float(max(-points.min(), points.max())) if len(points) else 0.0
    return not far * 2.0**-24 <= size * COARSE  # true for NaN


#: How lines keep the digits that float32 loses, and how other primitives do.
OFFSET_ADVICE = (
    "offset='auto' where lines are read or made keeps these digits (--option offset=auto on the command line)"
)
FLOAT64_ADVICE = "write a format whose coordinates are float64, such as .tck, .trx, .vtp or .npz"
SHIFT_ADVICE = "subtract the middle of the scene from them and from the origins of rays"


def warn_of_rounding(given: npt.ArrayLike, rounded: npt.NDArray[np.float32], advice: str = OFFSET_ADVICE) -> None:
    """Warn if the scene is so far from zero, for its size, that float32 rounds its coordinates noticeably.

    Invalid rows are reported elsewhere.
    """
    kept = rounded.reshape(-1, 3)
    if (isinstance(given, np.ndarray) and given.dtype == np.float32) or not is_far(kept):
        return
    good = np.abs(kept).max(axis=1) <= COORDINATE_LIMIT
    points = np.asarray(given, np.float64).reshape(-1, 3)[good]
    if not len(points):
        return
    size, far = float((points.max(axis=0) - points.min(axis=0)).max()), float(np.abs(points).max())
    warn_of_loss(float(np.abs(points - kept[good]).max()), far, size, advice)


def warn_of_loss(lost: float, far: float, size: float, advice: str = OFFSET_ADVICE) -> None:
    """Warn if float32 rounds coordinates by up to `lost`, up to `far` from zero, noticeably for the scene's size."""
    if lost > size * COARSE > 0:
        warn_caller(
            f"float32 rounds coordinates of up to {far:g}, in a scene of size {size:g}, by up to {lost:.2g}; {advice}",
            PrecisionWarning,
        )
