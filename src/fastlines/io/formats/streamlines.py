"""What formats of streamlines share: millimetres, axes to the Right, Anterior and Superior, values per streamline."""

from __future__ import annotations

import numpy as np

from ...arrays import AnyArray, FloatArray
from ..polylines import Polylines

UNIT = "mm"
UP = "z"


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
