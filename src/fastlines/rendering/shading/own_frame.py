"""Pictures of lines with an offset: they are made in the frame of the arrays of lines, which are less the offset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...camera import Camera
from ...geometry.offsets import NO_OFFSET
from ...tree import Tree


def in_own_frame(tree: Tree, camera: Camera) -> tuple[Tree, Camera]:
    """Return a tree over lines without an offset, and the camera that sees them as the given one sees the lines."""
    offset = tree.geometry.offset
    return (tree, camera) if offset == NO_OFFSET else (tree.without_offset(), moved(camera, np.negative(offset)))


def moved(camera: Camera, by: npt.ArrayLike) -> Camera:
    """Return a camera elsewhere, which looks in the same direction.

    Examples
    --------
    >>> moved(Camera(origin=(0, 0, 4), target=(0, 0, 0)), (10, 0, 0)).origin
    (10.0, 0.0, 4.0)
    """
    origin, target = (np.add(point, by) for point in (camera.origin, camera.target))
    return replace(camera, origin=tuple(origin.tolist()), target=tuple(target.tolist()))
