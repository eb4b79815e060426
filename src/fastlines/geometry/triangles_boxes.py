"""Triangles and boxes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..arrays import (
    FloatArray,
    box_of,
    column,
    list_rows,
    own_float32,
    refuse_rows,
    to_integers,
    unusable,
    warn_of_rounding,
)
from ..errors import InputError
from ..support.display import Shown
from ..support.immutable import frozen, own

#: The kinds of shapes, as cpp/fastlines/primitives/shapes.hpp numbers them.
ROUND_CONE, TRIANGLE, BOX, BOUND = range(4)


def shape_rows(shape: int, numbers: FloatArray) -> FloatArray:
    """Return shapes as the core reads them, (n, 10) float32: up to nine numbers of each, and its kind."""
    rows = np.zeros((len(numbers), 10), np.float32)
    rows[:, : numbers.shape[1]] = numbers
    rows[:, 9] = shape
    return np.asarray(own(rows))


@dataclass(frozen=True, eq=False)
class _Mesh(Shown):
    """Primitives as an array of their corners."""

    #: What the core calls the primitives.
    kind: ClassVar[str] = "shapes"
    name: ClassVar[str]
    shape: ClassVar[int]
    n_corners: ClassVar[int]

    corners: FloatArray
    attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    corner_attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)

    def __init__(
        self,
        corners: npt.ArrayLike,
        *,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        corner_attributes: Mapping[str, npt.ArrayLike] | None = None,
    ) -> None:
        array = own_float32(corners, self.name)
        if array.shape == (0,):
            array = array.reshape(0, self.n_corners, 3)
        if array.ndim != 3 or array.shape[1:] != (self.n_corners, 3):
            raise InputError(f"{self.name} have shape {array.shape}; expected (n, {self.n_corners}, 3)")
        warn_of_rounding(corners, array)
        refuse_rows(unusable(array), self.name)
        object.__setattr__(self, "corners", array)
        for kind, given in (("attributes", attributes), ("corner_attributes", corner_attributes)):
            columns = {name: column(values, name, len(array), self.name) for name, values in (given or {}).items()}
            object.__setattr__(self, kind, frozen(columns))
        for name, values in self.corner_attributes.items():
            if values.shape[:2] != (len(array), self.n_corners):
                raise InputError(
                    f"{name} has shape {values.shape}; expected ({len(array)}, {self.n_corners}, …): a value for each "
                    f"corner of the {self.name}"
                )

    def __len__(self) -> int:
        return len(self.corners)

    def __repr__(self) -> str:
        has = [f"{len(self):,} {self.name}", *self.attributes, *self.corner_attributes]
        return f"<{type(self).__name__}: {', '.join(has)}>"

    @cached_property
    def core_rows(self) -> FloatArray:
        """One row of numbers for each primitive, as the core reads them: (n, 10) float32."""
        return shape_rows(self.shape, self.corners.reshape(-1, 3 * self.n_corners))

    @property
    def bounds(self) -> FloatArray:
        """The box of all primitives as (2, 3): lowest and highest corner; lowest > highest if there are none."""
        return box_of(self.corners.reshape(-1, 3))


class Triangles(_Mesh):
    """Triangles, as an array of their corners.

    A ray hits a triangle where it crosses it, from either side. The radius of a query does not count: a triangle has no
    axis to be near to.

    Parameters
    ----------
    corners : (n, 3, 3) array
        Three corners each; converted to float32.
    attributes : mapping of str to array of n rows, optional
    corner_attributes : mapping of str to (n, 3, …) array, optional
        Values at the corners; `FirstHits.sample` interpolates them.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]))
    >>> hits = tree.first_hit([[0.2, 0.2, -1], [0.8, 0.8, -1]], [0, 0, 1])
    >>> print(hits.prim, hits.normals()[0])
    [ 0 -1] [ 0.  0. -1.]
    """

    name = "triangles"
    shape = TRIANGLE
    n_corners = 3

    @classmethod
    def from_mesh(
        cls,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        face_attributes: Mapping[str, npt.ArrayLike] | None = None,
    ) -> Triangles:
        """Make triangles of an indexed mesh.

        Parameters
        ----------
        vertices : (m, 3) array
        faces : (n, 3) array of int
            The vertices of each triangle.
        attributes : mapping of str to array of m rows, optional
            Values at the vertices.
        face_attributes : mapping of str to array of n rows, optional

        Raises
        ------
        InputError
            If a shape or a type cannot be used, or a face names a vertex that does not exist.

        Examples
        --------
        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> Triangles.from_mesh(square, [[0, 1, 2], [0, 2, 3]], attributes={"uv": [[0, 0], [1, 0], [1, 1], [0, 1]]})
        <Triangles: 2 triangles, uv>
        """
        points, rows = own_float32(vertices, "vertices"), to_integers(faces, "faces")
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"vertices have shape {points.shape}; expected (m, 3): x y z of each")
        rows = rows.reshape(0, 3) if rows.size == 0 else rows
        if rows.ndim != 2 or rows.shape[1] != 3:
            raise InputError(f"faces have shape {rows.shape}; expected (n, 3): the vertices of each triangle")
        wrong = np.asarray(((rows < 0) | (rows >= len(points))).any(axis=1), np.bool_)
        if wrong.any():
            raise InputError(
                f"{int(wrong.sum())} faces name none of the {len(points)} vertices ({list_rows(wrong)}); they count "
                "from 0"
            )
        warn_of_rounding(vertices, points)
        per_vertex = {
            name: column(values, name, len(points), "vertices") for name, values in (attributes or {}).items()
        }
        return cls(
            points[rows],
            attributes=face_attributes,
            corner_attributes={name: values[rows] for name, values in per_vertex.items()},
        )


class Boxes(_Mesh):
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
    shape = BOX
    n_corners = 2

    def __init__(self, corners: npt.ArrayLike, *, attributes: Mapping[str, npt.ArrayLike] | None = None) -> None:
        super().__init__(corners, attributes=attributes)
        inverted: npt.NDArray[np.bool_] = (self.corners[:, 1] - self.corners[:, 0]).min(axis=1, initial=0) < 0
        if inverted.any():
            raise InputError(
                f"{int(inverted.sum())} boxes have a low corner above their high one ({list_rows(inverted)})"
            )


def triangle_weights(corners: npt.NDArray[np.float64], points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the weights of the three corners of each triangle at a point of it, (n, 3); they add up to 1.

    A triangle without area gives each corner the same.
    """
    edges = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    normal = np.cross(edges[:, 2], -edges[:, 1])
    away = points[:, None] - corners[:, [1, 2, 0]]
    weights = (np.cross(edges, away) * normal[:, None]).sum(axis=2)
    total = weights.sum(axis=1, keepdims=True)
    return np.where(total != 0, weights / np.where(total != 0, total, 1), 1 / 3)
