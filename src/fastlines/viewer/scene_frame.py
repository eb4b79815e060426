"""The coordinates of the page: the middle of all boxes is at 0, and the longest side is 10.

A browser computes in float32 with near and far planes that suit such scenes, however large or far away lines are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..camera import Vector
from ..geometry.hit_places import Float64Array
from ..structure.tree_data import TreeData

#: The longest side of the box of everything, on the page.
SIDE = 10.0


@dataclass(frozen=True, eq=False)
class SceneFrame:
    """The way from the coordinates of arrays, and those of rays and files, to the page and back.

    Attributes
    ----------
    box : (2, 3) float64
        The box of everything with its own radius, without the offset.
    offset : (3,) float64
        What coordinates of rays and files have more than those of arrays.
    """

    box: Float64Array
    offset: Float64Array

    @classmethod
    def around(cls, tree: TreeData) -> SceneFrame:
        """Return the frame around a tree."""
        beyond = tree.geometry.radius_beyond
        box = tree.box.astype(np.float64) + np.array([[-beyond], [beyond]])
        return cls(box, np.array(tree.geometry.offset, np.float64))

    @property
    def size(self) -> float:
        """The longest side of the box, in the unit of the lines; 1 for a point."""
        side = float((self.box[1] - self.box[0]).max())
        return side if side > 0 else 1.0

    @property
    def scale(self) -> float:
        """How long a unit of the lines is on the page."""
        return SIDE / self.size

    def to_page(self, points: npt.NDArray[np.floating]) -> Float64Array:
        """Return where points of arrays are on the page.

        Examples
        --------
        >>> frame = SceneFrame(np.array([[0.0, 0, 0], [2, 4, 2]]), np.array([100.0, 0, 0]))
        >>> frame.to_page(np.array([1.0, 4.0, 1.0])).tolist(), frame.given_to_page(np.array([101.0, 2, 1])).tolist()
        ([0.0, 5.0, 0.0], [0.0, 0.0, 0.0])
        >>> frame.to_given((0.0, 5.0, 0.0)).tolist()
        [101.0, 4.0, 1.0]
        """
        return np.asarray((points - self.box.mean(axis=0)) * self.scale)

    def given_to_page(self, points: npt.NDArray[np.floating]) -> Float64Array:
        """Return where points are on the page whose coordinates are those of rays and files."""
        return self.to_page(points - self.offset)

    def to_given(self, place: Vector | Float64Array) -> Float64Array:
        """Return the point, in the coordinates of rays and files, of a place on the page."""
        return np.asarray(np.asarray(place, np.float64) / self.scale + self.box.mean(axis=0) + self.offset)
