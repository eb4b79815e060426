"""Checks of what lines are made of, and their conversion to segments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import (
    COORDINATE_LIMIT,
    AnyArray,
    FloatArray,
    IntArray,
    check_strands,
    column,
    is_far,
    kind_of,
    list_rows,
    neighbours,
    own_float32,
    refuse_rows,
    to_float32,
    to_integers,
    to_strands,
    unusable,
    warn_of_rounding,
)
from ..errors import InputError
from ..support.immutable import own
from .offsets import NO_OFFSET, check_offset

Columns = Mapping[str, npt.NDArray[Any]]

#: What to do about segments that hold NaN or Inf.
FIX_INVALID = (
    "; fix them, or leave them out: invalid='skip' where lines are read or a tree is built, --skip-invalid on the "
    "command line"
)


class Converted(NamedTuple):
    """Segments that may still hold invalid rows, with the columns of `Lines`."""

    segments: FloatArray
    strands: IntArray
    radius: FloatArray | None
    attributes: Columns
    end_attributes: Columns


def check_columns(
    n: int,
    strands: IntArray,
    radius: FloatArray | None,
    attributes: Columns,
    skipped: IntArray,
    end_attributes: Columns,
) -> None:
    """Refuse columns that do not fit n segments."""
    expected: dict[str, tuple[Any, type[Any], tuple[tuple[int, ...], ...]]] = {
        "strands": (strands, np.int64, ((n,),)),
        "radius": (radius, np.float32, ((n,), (n, 2))),
        "skipped": (skipped, np.int64, (np.shape(skipped)[:1],)),
    }
    for name, (values, dtype, shapes) in expected.items():
        if name == "radius" and values is None:
            continue
        if not isinstance(values, np.ndarray) or values.dtype != dtype or values.shape not in shapes:
            raise InputError(
                f"{name}: {kind_of(values)}; Lines of {n} segments take {np.dtype(dtype)} of shape "
                f"{' or '.join(map(str, shapes))}, and Lines.from_segments converts other arrays"
            )
    check_strands(strands)
    if radius is not None and not ((radius >= 0) & (radius <= COORDINATE_LIMIT)).all():
        raise InputError(f"radius holds values that are not numbers from 0 to {COORDINATE_LIMIT:g}")
    if len(skipped) and (skipped[0] < 0 or skipped[-1] >= n + len(skipped) or (np.diff(skipped) <= 0).any()):
        raise InputError(f"skipped are not rising rows of the {n + len(skipped)} that were given")
    for name, values in _mapping("attributes", attributes).items():
        if not isinstance(values, np.ndarray) or values.ndim == 0 or len(values) != n:
            raise InputError(f"{name}: {kind_of(values)}; expected an array with one row for each of {n} segments")
    for name, values in _mapping("end_attributes", end_attributes).items():
        if not isinstance(values, np.ndarray) or values.shape[:2] != (n, 2):
            raise InputError(f"{name}: {kind_of(values)}; expected an array of shape ({n}, 2, …), a value for each end")


def convert_segments(segments: npt.ArrayLike, more: dict[str, Any]) -> Converted:
    """Convert the arguments of `Lines.from_segments`."""
    expected = "expected (n, 2, 3): n segments, both ends, x y z; Lines.from_strands takes polylines"
    try:
        array = own_float32(segments, "segments")
    except InputError as error:
        raise InputError(f"{error}; {expected}") from None
    if array.ndim == 2 and array.shape[1] == 6:
        array = array.reshape(-1, 2, 3)
    if array.size == 0 and array.shape in ((0,), (0, 2, 3)):
        array = array.reshape(0, 2, 3)
    if array.ndim != 3 or array.shape[1:] != (2, 3):
        raise InputError(f"segments have shape {array.shape}; {expected}")
    warn_of_rounding(segments, array)
    n_given = len(array)
    strands = to_strands(more.pop("strands", np.broadcast_to(-1, n_given)))
    radius = more.pop("radius", None)
    radius = None if radius is None else own_float32(radius, "radius")
    if radius is not None and radius.ndim == 0:
        radius = own(np.full(n_given, radius))
    attributes, end_attributes = (
        {name: column(values, name, n_given, "segments") for name, values in _mapping(kind, more.pop(kind, {})).items()}
        for kind in ("attributes", "end_attributes")
    )
    if both := attributes.keys() & end_attributes.keys():
        raise InputError(f"{min(both)!r} is in attributes and in end_attributes; give it once")
    if more:
        raise InputError(f"unknown argument {next(iter(more))!r}; known: strands, radius, attributes, end_attributes")
    if strands.shape != (n_given,):
        raise InputError(f"strands have shape {strands.shape}; expected ({n_given},), one for each segment")
    if radius is not None and radius.shape not in ((n_given,), (n_given, 2)):
        raise InputError(
            f"radius has shape {radius.shape}; expected ({n_given},) or ({n_given}, 2), one for each segment or end"
        )
    return Converted(array, strands, radius, attributes, end_attributes)


def valid_segments(given: Converted, invalid: str) -> tuple[Converted, IntArray]:
    """Leave out, or refuse, segments with NaN, Inf or too large a coordinate or radius; return the rows left out."""
    n_given, radius = len(given.segments), given.radius
    bad = unusable(given.segments)
    if radius is not None:
        good = (radius >= 0) & (radius <= COORDINATE_LIMIT)
        bad_radius = np.asarray(~(good.all(axis=1) if radius.ndim == 2 else good))
        if invalid == "error" and bad_radius.any():
            raise InputError(
                f"radius: {int(bad_radius.sum())} of {n_given} are not numbers from 0 to {COORDINATE_LIMIT:g} "
                f"({list_rows(bad_radius)}); fix them, or leave them out with invalid='skip'"
            )
        bad = bad | bad_radius
    if invalid == "error":
        refuse_rows(bad, "segments", FIX_INVALID)
    if bad.any():
        given = Converted(
            own(given.segments[~bad]),
            own(given.strands[~bad]),
            None if radius is None else own(radius[~bad]),
            {name: own(values[~bad]) for name, values in given.attributes.items()},
            {name: own(values[~bad]) for name, values in given.end_attributes.items()},
        )
    return given, np.flatnonzero(bad)


def join_points(
    points: npt.ArrayLike,
    counts: npt.ArrayLike,
    radius: npt.ArrayLike | None,
    attributes: Mapping[str, npt.ArrayLike] | None,
) -> dict[str, Any]:
    """Join consecutive points to strands; return the arguments of `Lines.from_segments`."""
    given, points = points, _points(points, "points")
    warn_of_rounding(given, points)
    counts = to_integers(counts, "counts")
    if counts.ndim != 1 or (counts < 0).any() or (counts > len(points)).any() or counts.sum() != len(points):
        raise InputError(
            f"the counts of the strands do not add up to the {len(points)} points that were given; expected one "
            "count, 0 or more, for each strand"
        )
    per_point = {name: column(values, name, len(points), "points") for name, values in (attributes or {}).items()}
    radii = None if radius is None else to_float32(radius, "radius")
    if radii is not None:
        radii = column(radii if radii.ndim else np.full(len(points), radii), "radius", len(points), "points")

    # Join each point and the next one, but for the last of each strand; a lone point joins itself.
    sizes = counts[counts > 0]
    return {
        "segments": own(neighbours(points, sizes)),
        "strands": own(np.repeat(np.flatnonzero(counts > 0), np.maximum(sizes - 1, 1))),
        "radius": None if radii is None else own(neighbours(radii, sizes)),
        "end_attributes": {name: own(neighbours(values, sizes)) for name, values in per_point.items()},
    }


def join_strands(
    strands: Iterable[npt.ArrayLike], radius: Any, attributes: Mapping[str, Any], offset: Any
) -> dict[str, Any]:
    """Join polylines and their values; return the arguments of `Lines.from_points`."""
    given = list(strands)
    parts: Sequence[FloatArray] = [_points(strand, f"strand {i}") for i, strand in enumerate(given)]
    points: AnyArray = np.concatenate(parts) if parts else np.empty((0, 3), np.float32)
    if parts and check_offset(offset) != NO_OFFSET:
        points = np.concatenate([np.reshape(np.asarray(strand, np.float64), (-1, 3)) for strand in given])
    elif is_far(points):
        warn_of_rounding(np.concatenate([np.reshape(strand, (-1, 3)) for strand in given]), points)
    counts = [len(part) for part in parts]
    return {
        "points": points,
        "counts": counts,
        "offset": offset,
        "radius": _per_point("radius", radius, counts),
        "attributes": {name: _per_point(name, values, counts) for name, values in attributes.items()},
    }


def _per_point(name: str, values: Any, counts: list[int]) -> Any:
    """Join arrays of the values of each strand; return what else was given, such as one number, as it is."""
    if not hasattr(values, "__len__") or (isinstance(values, np.ndarray) and values.ndim == 0):
        return values
    if len(values) != len(counts) or not all(hasattr(part, "__len__") for part in values):
        return values
    sizes = [len(part) for part in values]
    if sizes == counts:
        return np.concatenate([np.asarray(part) for part in values]) if counts else values
    if sum(counts) == len(counts):
        return values
    i = next(i for i, size in enumerate(sizes) if size != counts[i])
    raise InputError(f"{name} has {sizes[i]} values for strand {i}; expected {counts[i]}, one for each of its points")


def _mapping(name: str, values: object) -> Mapping[str, Any]:
    if not isinstance(values, Mapping):
        raise InputError(f"{name} are {kind_of(values)}; expected a mapping of names to arrays")
    return values


def _points(values: npt.ArrayLike, name: str) -> FloatArray:
    array = to_float32(values, name)
    if array.size == 0:
        return array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{name}: the shape is {array.shape}; expected (m, 3): x y z of each point")
    return array
