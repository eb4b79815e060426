"""Where rays enter boxes, in float64."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..geometry.hit_places import Float64Array


def enter(
    boxes: npt.NDArray[np.floating], origins: Float64Array, directions: Float64Array, grow: float
) -> Float64Array:
    """Return where each ray enters its box, which is grown on all sides: t ≥ 0, or inf for a miss.

    Parameters
    ----------
    boxes : (n, 2, 3) array
    origins, directions : (n, 3) or (3,) float64
    grow : float

    Examples
    --------
    >>> import numpy as np
    >>> boxes = np.array([[[0, 0, 0], [1, 1, 1]], [[2, 2, 2], [3, 3, 3]]], np.float32)
    >>> enter(boxes, np.array([0.5, 0.5, -4]), np.array([0.0, 0.0, 1.0]), 0.5)
    array([3.5, inf])
    """
    entered, left = np.zeros(len(boxes)), np.full(len(boxes), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in range(3):
            low = boxes[:, 0, axis].astype(np.float64) - grow - origins[..., axis]
            high = boxes[:, 1, axis].astype(np.float64) + grow - origins[..., axis]
            inverse = 1 / directions[..., axis]
            one, other = low * inverse, high * inverse
            # A ray in the plane of a face gives 0·inf = NaN, and hits: fmax and fmin pass over NaN.
            entered, left = np.fmax(entered, np.minimum(one, other)), np.fmin(left, np.maximum(one, other))
    return np.where(entered <= left, entered, np.inf)
