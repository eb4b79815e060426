"""What float32 keeps of coordinates, and a warning where that is not enough for their scene."""

from __future__ import annotations

import warnings

import numpy as np
import numpy.typing as npt

from .errors import PrecisionWarning

#: Coordinates beyond this would overflow when squared in the arithmetic of the builders.
COORDINATE_LIMIT = 1e30

#: The rounding error of a coordinate that is worth a warning, as a fraction of the scene's longest side.
COARSE = 2.0**-18


def is_far(points: npt.NDArray[np.float32]) -> bool:
    """Return whether (n, 3) points may be so far from zero, for the size of their scene, that float32 is too coarse."""
    some = _usable(points[:: len(points) // 1024 + 1])
    size = float((some.max(axis=0) - some.min(axis=0)).max()) if len(some) else 0.0
    far = float(max(-points.min(), points.max())) if len(points) else 0.0
    return not far * 2.0**-24 <= size * COARSE  # nor is NaN


def warn_of_rounding(given: npt.ArrayLike, rounded: npt.NDArray[np.float32]) -> None:
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
    lost = float(np.abs(points - kept[good]).max())
    if lost > size * COARSE > 0:
        warnings.warn(
            f"coordinates of up to {far:g}, of a scene of size {size:g}, are moved by up to {lost:.2g} as float32; "
            "subtract the middle of the scene from them, and from the origins of rays",
            PrecisionWarning,
            stacklevel=3,
        )


def _usable(points: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    usable: npt.NDArray[np.float32] = points[np.abs(points).max(axis=1) <= COORDINATE_LIMIT]
    return usable
