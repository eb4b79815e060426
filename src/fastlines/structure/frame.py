"""The frame of a tree: the box whose centre and size define the coordinates that queries compute in."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import COORDINATE_LIMIT, FloatArray, to_float32
from ..errors import InputError
from ..support.immutable import own


def frame_around(box: FloatArray | None, frame: npt.ArrayLike | None) -> FloatArray | None:
    """Check that a frame holds a box, that of the axes of all primitives, or None; and return it as float32."""
    if frame is None:
        return None
    corners = np.array(to_float32(frame, "frame"))
    if corners.shape != (2, 3):
        raise InputError(f"frame has shape {corners.shape}; expected (2, 3): the low and the high corner of a box")
    if not (np.abs(corners) <= COORDINATE_LIMIT).all():
        raise InputError(f"frame holds NaN, Inf or a coordinate beyond {COORDINATE_LIMIT:g}: {corners.tolist()}")
    if (corners[0] > corners[1]).any():
        raise InputError(f"the low corner of frame is above the high one: {corners.tolist()}; swap them")
    outside = 0 if box is None else np.maximum(corners[0] - box[0], box[1] - corners[1]).max()
    if outside > 0:
        raise InputError(
            f"the primitives extend {outside:g} beyond frame={corners.tolist()}; expected a box that holds them all, "
            "such as the bounds of the whole scene"
        )
    return own(corners)
