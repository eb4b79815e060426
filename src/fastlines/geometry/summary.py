"""What `fastlines info` says about a geometry, ready for JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..arrays import box_of
from .offsets import NO_OFFSET

if TYPE_CHECKING:
    from .any_geometry import AnyGeometry


def summary_of(
    geometry: AnyGeometry, counts: Mapping[str, int], lengths: Mapping[str, float | None] | None = None
) -> dict[str, Any]:
    """Return counts and sizes of a geometry, after those of its primitives; `lengths` are more of these."""
    points, radii = geometry.span()
    bounds = box_of(points) if len(points) else None
    corners = bounds if bounds is None or geometry.offset == NO_OFFSET else bounds + np.array(geometry.offset)
    texts = geometry.attribute_texts()
    return {
        **counts,
        "n_strands": geometry.n_strands,
        "bounds": None if corners is None else corners.tolist(),
        "size": None if bounds is None else (bounds[1] - bounds[0]).tolist(),
        "total_length": geometry.total_length,
        **(lengths or {}),
        "strand_lengths": extremes(geometry.strand_lengths()),
        "n_zero_length": geometry.count_points(),
        "radius": [float(radii.min()), float(radii.max())] if radii.any() else None,
        "attributes": {name: " or ".join(texts[name]) for name in sorted(texts)},
        **({} if geometry.offset == NO_OFFSET else {"offset": list(geometry.offset)}),
        "up": geometry.up,
        "unit": geometry.unit,
        "n_skipped": geometry.n_skipped,
        "memory_bytes": geometry.core_rows.nbytes,
    }


def extremes(lengths: npt.NDArray[np.float64]) -> list[float] | None:
    """Return the least, the median and the greatest length; None if there are none."""
    if not len(lengths):
        return None
    return [float(lengths.min()), float(np.median(lengths)), float(lengths.max())]
