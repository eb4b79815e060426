"""What formats of streamlines share: millimetres, axes to the Right, Anterior and Superior, values per streamline."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray
from ...immutable import own
from ...lines import Lines
from ..polylines import Polylines
from ..written import strand_numbers

AnyArray = npt.NDArray[Any]

UNIT = "mm"
UP = "z"


def with_values(lines: Lines, values: Mapping[str, AnyArray], of: str = "streamline") -> Lines:
    """Return lines with attributes that have a row for each strand; `of` is appended to a name that is taken."""
    if not values:
        return lines
    named = {f"{name} of {of}" if name in lines.attributes else name: part for name, part in values.items()}
    return replace(lines, attributes={**lines.attributes, **{name: own(v[lines.strands]) for name, v in named.items()}})


def foreign(lines: Lines, strand: npt.NDArray[np.int64]) -> list[str]:
    """Describe what of lines no format of streamlines keeps: another unit or axis, and other numbers of strands."""
    lost = strand_numbers(strand)
    if lines.unit not in (None, UNIT):
        lost.append(f"the unit {lines.unit!r} (coordinates are written as they are, and will be read as {UNIT})")
    if lines.up not in (None, UP):
        lost.append(f"the upward axis {lines.up!r} (coordinates are written as they are, and {UP} will be up)")
    return lost


def dimensions(points: FloatArray) -> list[int]:
    """Return the numbers of voxels of 1 mm in an image from 0 to the farthest point, as far as 16 bits can count."""
    far = points.max(axis=0, initial=0).astype(np.float64)
    return [int(n) for n in np.clip(np.ceil(far + 0.5), 1, np.iinfo(np.int16).max)]


def split_values(lines: Polylines) -> tuple[dict[str, AnyArray], dict[str, AnyArray], list[str]]:
    """Return the values per point, the radius among them, those per polyline, and what is lost by that, in words."""
    per_point, lost = dict(lines.point_attributes), list(lines.lost)
    if lines.radius is not None:
        name = "radius"
        while name in per_point or name in lines.attributes:
            name += "_"
        per_point[name] = lines.radius
        lost.append(f"that {name!r} is the radius, and not just a value per point")
    return per_point, dict(lines.attributes), lost
