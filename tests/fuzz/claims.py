"""What holds of each file, however damaged it is: it is read as usable lines, or one sentence says what is wrong."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np

import fastlines as fl
from fastlines.arrays import COORDINATE_LIMIT
from fastlines.structure.geometry_file import to_sections

T = TypeVar("T")

#: A file of up to 64 KB is read or refused in so many seconds of one processor.
MAX_SECONDS = 1.0
#: An error is one line of at most so many characters.
MAX_MESSAGE = 1000


class FaultError(AssertionError):
    """Something that may not happen."""


def require(holds: bool, what: str) -> None:
    """Raise a fault unless something holds."""
    if not holds:
        raise FaultError(what)


def made_or_refused(make: Callable[[], T]) -> T | fl.FastlinesError:
    """Return what is made, or the error of one line that refuses it; anything else that is raised is a fault."""
    start = time.monotonic()
    try:
        made: T | fl.FastlinesError = make()
    except fl.MissingExtraError:
        raise
    except fl.FastlinesError as error:
        text = str(error)
        require(bool(text) and text.isprintable(), f"the error is not one printable line: {text!r}")
        require(len(text) <= MAX_MESSAGE, f"the error has {len(text)} characters")
        made = error
    if time.monotonic() - start > MAX_SECONDS:  # perhaps others had the processor
        check_time(make)
    return made


def check_time(make: Callable[[], object]) -> None:
    """Check how much time of a processor is taken."""
    start = time.thread_time()
    with suppress(fl.FastlinesError):
        make()
    seconds = time.thread_time() - start
    require(seconds <= MAX_SECONDS, f"it took {seconds:.1f} s")


def check_usable(geometry: Any, *, may_skip: bool) -> None:
    """Check that lines or curves are what their documentation says, with finite coordinates and columns that fit."""
    for part in geometry.each_part():
        n = len(part)
        points = getattr(part, next(iter(part.sections)))
        require(points.dtype == np.float32 and len(points) == n, f"points are {points.dtype} {points.shape}, n is {n}")
        require(bool((np.abs(points) <= COORDINATE_LIMIT).all()), "coordinates are not finite")
        require(part.strands.dtype == np.int64 and part.strands.shape == (n,), "strands are not a column of int64")
        require(bool((part.strands >= -1).all()), "a strand is below -1")
        if part.radius is not None:
            require(len(part.radius) == n, "the radius is no column")
            inside = slice(None) if part.radius.shape[1:] != (4,) else slice(None, None, 3)  # of a Bezier curve
            ends = part.radius if part.radius.ndim == 1 else part.radius[:, inside]
            require(bool(np.isfinite(part.radius).all() and (ends >= 0).all()), "a radius is not usable")
        for name, values in part.attributes.items():
            require(values.shape[:1] == (n,), f"the attribute {name!r} is no column")
        for name, values in part.end_attributes.items():
            require(values.shape[:2] == (n, 2), f"the attribute {name!r} is no column of both ends")
        skipped = part.skipped
        require(may_skip or not len(skipped), "rows are skipped without invalid='skip'")
        require(bool((np.diff(skipped, prepend=-1) > 0).all()), "the skipped rows do not rise")
        require(bool((skipped < n + len(skipped)).all()), "a skipped row is not there")
        if not isinstance(part, fl.Lines):
            continue
        offsets = part.offsets
        require(offsets[0] == 0 and bool((np.diff(offsets) > 0).all()), "the polylines' offsets do not rise")
        require(len(part.points) == offsets[-1], "the polylines' offsets do not end at their points")


def same_bits(one: Any, other: Any) -> bool:
    """Return whether arrays have one type, one shape and the same bytes, or whether there are none."""
    if one is None or other is None:
        return one is other
    return bool((one.dtype, one.shape) == (other.dtype, other.shape) and one.tobytes() == other.tobytes())


def same_numbers(one: Any, other: Any) -> bool:
    """Return whether arrays have the same bits, but for signs of zeros and NaN that signal.

    Zero and -0 are one point where they meet, and what is added to a NaN that signals makes it a quiet one.
    """
    with np.errstate(invalid="ignore"):
        return same_bits(*(array + array.dtype.type(0) if array.dtype.kind == "f" else array for array in (one, other)))


def check_same(one: Any, other: Any, what: str, same: Callable[[Any, Any], bool] = same_bits) -> None:
    """Check that lines or curves are the same, bit for bit, or by another comparison of arrays."""
    (arrays, facts, _), (others, other_facts, _) = to_sections(one), to_sections(other)
    require(set(arrays) == set(others), f"{what}: the columns are {list(others)}; expected {list(arrays)}")
    for name, array in arrays.items():
        require(same(array, others[name]), f"{what}: {name} differ")
    require(repr(facts) == repr(other_facts), f"{what}: {other_facts}; expected {facts}")


def with_warnings(make: Callable[[], T]) -> tuple[T, list[str]]:
    """Return what is made, and the warnings on the way."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", fl.FileWarning)
        made = make()
    return made, [str(warning.message) for warning in said]
