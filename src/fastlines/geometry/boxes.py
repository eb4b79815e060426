"""Boxes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, list_rows
from ..errors import InputError
from ..support.vectors import dot
from .any_geometry import Section
from .hit_places import Float64Array, HitPlaces
from .mesh import Mesh
from .shapes import BOX

#: Which end of each axis a corner has, and the corners of each side.
CORNERS = np.indices((2, 2, 2)).reshape(3, 8).T
SIDES = np.array([[0, 2, 3, 1], [4, 6, 7, 5], [0, 4, 5, 1], [2, 6, 7, 3], [0, 4, 6, 2], [1, 5, 7, 3]])


class Boxes(Mesh):
    """Solid boxes.

    A ray hits a box where it is inside. The radius of a query does not count.

    Parameters
    ----------
    corners : (n, 2, 3) array
        Lowest and highest corner of each; converted to float32.
    attributes : mapping of str to array of n rows, optional

    Examples
    --------
    >>> import fastlines as fl
    >>> hits = fl.build(Boxes([[[0, 0, 0], [1, 1, 1]]])).first_hit([0.5, 0.5, -1], [0, 0, 1], at="surface")
    >>> print(hits.t, hits.t_out)
    1.0 2.0
    """

    name = "boxes"
    word = "box"
    shape = BOX
    n_corners = 2
    sections: ClassVar[Mapping[str, Section]] = {"corners": ("<f4", ((2, 3),), True)}

    def __init__(self, corners: npt.ArrayLike, *, attributes: Mapping[str, npt.ArrayLike] | None = None) -> None:
        super().__init__(corners, attributes=attributes)
        inverted: npt.NDArray[np.bool_] = (self.corners[:, 1] - self.corners[:, 0]).min(axis=1, initial=0) < 0
        if inverted.any():
            raise InputError(
                f"{int(inverted.sum())} of {len(inverted)} boxes have a low corner above their high one "
                f"({list_rows(inverted)})"
            )

    # --- What a kind of geometry answers ---

    def span(self) -> tuple[FloatArray, FloatArray]:
        """Return all eight corners of each box."""
        points = corners_of(self.corners).reshape(-1, 3)
        return points, np.zeros(len(points), np.float32)

    def points_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return hits.entering_at(self._enter(hits).max(axis=1)).on_rays()

    def nearest_at(self, hits: HitPlaces, surface: bool) -> Float64Array:
        """Return the origin itself where it is inside."""
        low, high = np.moveaxis(self.corners[hits.prim].astype(np.float64), 1, 0)
        return np.clip(hits.origins, low, high)

    def normals_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        # Take the face of the plane that the ray crosses last on its way in.
        rows, axis = np.arange(len(hits.prim)), self._enter(hits).argmax(axis=1)
        away = np.zeros((len(rows), 3))
        away[rows, axis] = -np.sign(hits.directions[rows, axis])
        return hits.outwards(away)

    def _enter(self, hits: HitPlaces) -> Float64Array:
        """Return the t at which rays come in between each pair of planes, (n, 3); −inf where they are parallel."""
        low, high = np.moveaxis(self.corners[hits.prim].astype(np.float64), 1, 0)
        plane = np.where(hits.directions > 0, low, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (plane - hits.origins) / hits.directions
        parallel = np.abs(hits.directions) < 1e-6 * np.sqrt(dot(hits.directions, hits.directions))[:, None]
        return np.where(parallel, -np.inf, t)

    def outlines(self) -> tuple[Float64Array, Float64Array]:
        """Return the sides of each box."""
        corners = corners_of(self.corners).astype(np.float64)[:, SIDES].reshape(-1, 4, 3)
        return corners, np.zeros(corners.shape[:2])


def corners_of(boxes: FloatArray) -> FloatArray:
    """Return the eight corners of boxes (n, 2, 3), (n, 8, 3)."""
    return boxes[:, CORNERS, np.arange(3)]
