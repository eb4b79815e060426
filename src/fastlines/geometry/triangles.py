"""Triangles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ..arrays import SHIFT_ADVICE, IntArray, column, list_rows, own_float32, to_integers, warn_of_rounding
from ..errors import InputError
from ..support.vectors import dot
from .any_geometry import Section
from .hit_places import Float64Array, HitPlaces
from .mesh import Mesh
from .shapes import TRIANGLE


class Triangles(Mesh):
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
    word = "triangle"
    shape = TRIANGLE
    n_corners = 3
    sections: ClassVar[Mapping[str, Section]] = {"corners": ("<f4", ((3, 3),), True)}

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
        warn_of_rounding(vertices, points, SHIFT_ADVICE)
        per_vertex = {
            name: column(values, name, len(points), "vertices") for name, values in (attributes or {}).items()
        }
        return cls(
            points[rows],
            attributes=face_attributes,
            corner_attributes={name: values[rows] for name, values in per_vertex.items()},
        )

    # --- What a kind of geometry answers ---

    def points_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        corners, normal = self._planes(hits.prim)
        with np.errstate(divide="ignore", invalid="ignore"):
            above, facing = (dot(normal, x) for x in (corners[:, 0] - hits.origins, hits.directions))
            t = above / facing
        # If the ray is nearly parallel to the triangle, its plane does not determine t.
        length = np.sqrt(dot(normal, normal) * dot(hits.directions, hits.directions))
        return hits.entering_at(np.where(np.abs(facing) > 1e-3 * length, t, np.nan)).on_rays()

    def nearest_at(self, hits: HitPlaces, surface: bool) -> Float64Array:
        """See `AnyGeometry`."""
        return nearest_on_triangles(self.corners[hits.prim].astype(np.float64), hits.origins)

    def normals_at(self, hits: HitPlaces) -> Float64Array:
        """Return the normals of the sides that rays come from."""
        away = self._planes(hits.prim)[1]
        away[dot(away, hits.directions) > 0] *= -1
        return hits.outwards(away)

    def _planes(self, prim: IntArray) -> tuple[Float64Array, Float64Array]:
        """Return the corners of some triangles, and vectors across them."""
        corners = self.corners[prim].astype(np.float64)
        return corners, np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    def place_weights(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return triangle_weights(self.corners[hits.prim].astype(np.float64), hits.on_rays())


def nearest_on_triangles(corners: Float64Array, points: Float64Array) -> Float64Array:
    """Return the point of each triangle (n, 3, 3) that is nearest to a point, (n, 3)."""
    first, second, third = np.moveaxis(corners, 1, 0)
    # Take the nearest point of each edge, and the projection where that is inside.
    found = [nearest_on_edges(*ends, points) for ends in ((first, second), (second, third), (third, first))]
    normal = np.cross(second - first, third - first)
    length2 = dot(normal, normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        projected = points - (dot(points - first, normal) / length2)[:, None] * normal
        away = [np.cross(b - a, projected - a) for a, b in ((first, second), (second, third), (third, first))]
        is_inside = (np.stack([dot(vectors, normal) for vectors in away]) >= 0).all(axis=0) & (length2 > 0)
    found.append(np.where(is_inside[:, None], projected, found[0]))
    places = np.stack(found)
    best = dot(places - points, places - points).argmin(axis=0)
    return np.asarray(places[best, np.arange(len(points))])


def nearest_on_edges(start: Float64Array, end: Float64Array, points: Float64Array) -> Float64Array:
    """Return the point of each edge, (n, 3), that is nearest to a point."""
    edge = end - start
    length2 = dot(edge, edge)
    s = np.clip(dot(points - start, edge) / np.where(length2 > 0, length2, 1), 0, 1)[:, None]
    return np.where(s < 1, start + s * edge, end)


def triangle_weights(corners: Float64Array, points: Float64Array) -> Float64Array:
    """Return the weights of the three corners of each triangle at a point of it, (n, 3); they add up to 1.

    A triangle without area gives each corner the same.
    """
    edges = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    normal = np.cross(edges[:, 2], -edges[:, 1])
    away = points[:, None] - corners[:, [1, 2, 0]]
    weights = (np.cross(edges, away) * normal[:, None]).sum(axis=2)
    total = weights.sum(axis=1, keepdims=True)
    return np.where(total != 0, weights / np.where(total != 0, total, 1), 1 / 3)
