"""Offsets: what is subtracted from coordinates in float64, before they are rounded to float32.

Coordinates far from zero lose digits in float32. Less an offset in the middle of their scene, they keep them.
Containers have the offset in their metadata. Their arrays and trees are less the offset, and everything else is not:
rays, points, cameras and files have the coordinates that were given.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import COORDINATE_LIMIT, warn_of_rounding
from ..errors import InputError, PrecisionWarning
from ..support.metadata import read_only
from ..support.warn_caller import warn_caller

Offset: TypeAlias = tuple[float, float, float]

#: The name of the offset in the metadata, and in the options of what makes lines.
OFFSET = "offset"
AUTO = "auto"
NO_OFFSET: Offset = (0.0, 0.0, 0.0)


def check_offset(offset: object) -> Offset | str:
    """Check an offset: three numbers, or "auto"; None is no offset.

    Examples
    --------
    >>> check_offset([5_300_000, 0, 0]), check_offset("auto"), check_offset(None)
    ((5300000.0, 0.0, 0.0), 'auto', (0.0, 0.0, 0.0))
    """
    if offset is None:
        return NO_OFFSET
    if isinstance(offset, str):
        if offset == AUTO:
            return AUTO
    else:
        try:
            x, y, z = (float(value) for value in offset)  # type: ignore[attr-defined]
        except (TypeError, ValueError, OverflowError):
            pass
        else:
            if all(abs(value) <= COORDINATE_LIMIT for value in (x, y, z)):
                return x + 0.0, y + 0.0, z + 0.0
    raise InputError(f"offset={offset!r}; expected 'auto', or three numbers that are subtracted from x, y and z")


def offset_of(metadata: Mapping[str, Any]) -> Offset:
    """Return the offset of a container with this metadata.

    Raises
    ------
    InputError
        If it is not three numbers.
    """
    if (given := metadata.get(OFFSET)) is None:
        return NO_OFFSET
    found = check_offset(given)
    if isinstance(found, str):
        raise InputError(f"metadata have the offset {found!r}; expected three numbers")
    return found


def checked_metadata(metadata: Any) -> Mapping[str, Any]:
    """Return a read-only copy of metadata, whose offset is checked."""
    made = read_only(metadata)
    offset_of(made)
    return made


def reduced(points: npt.ArrayLike, offset: object) -> tuple[Any, dict[str, Any]]:
    """Return points less an offset in float64, and the metadata that keep it.

    Parameters
    ----------
    points : (…, 3k) array of numbers
        What cannot be used is returned as it is, for the checks that follow.
    offset : None, "auto" or three numbers

    Examples
    --------
    >>> points, metadata = reduced([[5_300_000.25, 10, 1], [5_300_002.25, 20, 1]], "auto")
    >>> points.tolist(), metadata
    ([[-0.75, -5.0, 0.0], [1.25, 5.0, 0.0]], {'offset': (5300001.0, 15.0, 1.0)})
    """
    wanted = check_offset(offset)
    if wanted == NO_OFFSET:
        return points, {}
    try:
        given = np.asarray(points)
    except ValueError:
        return points, {}
    if np.ma.is_masked(points) or given.dtype.kind not in "fiub" or not given.ndim or given.shape[-1] % 3:
        return points, {}
    rows = given.reshape(-1, 3).astype(np.float64)
    place = middle_of(rows) if isinstance(wanted, str) else wanted
    if place == NO_OFFSET:
        return points, {}
    with np.errstate(invalid="ignore", over="ignore"):
        rows -= place
    return rows.reshape(given.shape), {OFFSET: place}


def in_file(part: Any, points: npt.NDArray[np.float32]) -> npt.NDArray[Any]:
    """Return points of a container as they are written: its offset is added in float64, if it has one."""
    return points if part.offset == NO_OFFSET else points + np.array(part.offset)


def with_metadata(part: Any, metadata: Mapping[str, Any]) -> dict[str, Any]:
    """Return the metadata of a file, with the offset that its lines were read with in place of the file's own."""
    own = {OFFSET: part.metadata[OFFSET]} if OFFSET in part.metadata else {}
    return {name: value for name, value in metadata.items() if name != OFFSET} | own


def with_offset(part: Any, offset: object) -> Any:
    """Return lines or curves with another offset, so that their points are in the same places.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = with_offset(fl.Lines.from_segments([[[8, 0, 0], [10, 0, 0]]]), "auto")
    >>> lines.segments.tolist(), lines.offset, lines.points.tolist()
    ([[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]], (9.0, 0.0, 0.0), [[8.0, 0.0, 0.0], [10.0, 0.0, 0.0]])
    """
    name = next(iter(part.sections))
    points, facts = reduced(getattr(part, name).astype(np.float64) + part.offset, offset)
    rounded = np.asarray(points, np.float32, order="C")
    warn_of_rounding(points, rounded)
    metadata = {key: value for key, value in part.metadata.items() if key != OFFSET} | facts
    return replace(part, **{name: rounded}, metadata=metadata)


def warn_of_places(parts: Sequence[Any]) -> None:
    """Warn of triangles and boxes that lie where the lines beside them would be without an offset."""
    lines = [part for part in parts if part.has_axes and len(part)]
    if not lines or lines[0].offset == NO_OFFSET:
        return
    offset = lines[0].offset
    corners = np.stack([part.bounds for part in lines])
    low, high = corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
    for i, part in enumerate(parts):
        if part.has_axes or not len(part):
            continue
        least, most = part.bounds.astype(np.float64)
        apart, apart_without = (((most < low + by) | (least > high + by)).any() for by in (0, np.array(offset)))
        if apart and not apart_without:
            warn_caller(
                f"part {i} ({part.count_text()}) lies far from the lines, which are less their offset, {offset}: "
                f"subtract it from the corners of part {i}, too",
                PrecisionWarning,
            )


def middle_of(points: npt.NDArray[Any]) -> Offset:
    """Return the offset that "auto" stands for: the middle of the box of points (m, 3), rounded.

    It is rounded to whole numbers; where the box is smaller than 1, to as many decimals as its longest side needs.

    Examples
    --------
    >>> middle_of(np.array([[16.2, 48.1, 0], [16.9, 48.2, 0]])), middle_of(np.array([[0.51234, 7, 1], [0.51238, 7, 1]]))
    ((16.5, 48.2, 0.0), (0.51236, 7.0, 1.0))
    """
    if not len(points):
        return NO_OFFSET
    # Reduce one axis after the other, which is faster; mostly all points are usable.
    low, high = (np.array([reduce(points[:, i]) for i in range(3)], np.float64) for reduce in (np.min, np.max))
    if (low >= -COORDINATE_LIMIT).all() and (high <= COORDINATE_LIMIT).all():
        return rounded_middle(low, high)
    with np.errstate(invalid="ignore"):
        return middle_of(points[(np.abs(points) <= COORDINATE_LIMIT).all(axis=1)])


def rounded_middle(low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]) -> Offset:
    """Return the middle of a box, rounded as `middle_of` says."""
    size = float((high - low).max())
    decimals = math.ceil(-math.log10(size)) if 0 < size < 1 else 0
    x, y, z = (float(value) + 0.0 for value in np.round((low + high) / 2, min(decimals, 15)))
    return x, y, z
