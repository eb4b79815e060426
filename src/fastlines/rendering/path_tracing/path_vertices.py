"""Where paths of light scatter: points at the surface of fibres, and where the rays that leave them start.

The scattering model takes a fibre as a whole: light that leaves it, also on its other side, starts outside. So a ray in
the direction ω from the point q, counted from the axis, starts where it leaves the fibre of the radius R:

    t = (√((q·ω')² + |ω'|² (R² − |q|²)) − q·ω') / |ω'|²,     ω' the part of ω across the axis.

Rays that are reflected start at once, and rays that pass the whole width start after 2R / cos θ.
(`secondary_rays` is about other fibres within that distance.)
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...query.hits import AllHits
from ...support.vectors import dot, is_zero, unit
from ..shading.fragments import Fragments
from ..shading.shading_context import ShadingContext

#: The least |ω'|. A ray almost parallel to a straight fibre would leave it far away, but real fibres bend.
STEEPEST = 0.05
#: Rays start this much farther, as a fraction of the radius: at a joint, the next segment bends away.
MARGIN = 0.02
#: The same as a fraction of the scene's extent, for surfaces and for hairs whose radius is 0 at the tip.
LEAST = 2.0**-20


@dataclass(frozen=True)
class PathVertices:
    """Points of fibres, each seen from somewhere.

    Attributes
    ----------
    points, normals : (n, 3) float32
        At the surface, and outwards.
    tangents : (n, 3) float32
        Unit vectors along the fibres; zero for surfaces without an axis.
    to_eye : (n, 3) float32
        Unit vectors towards where the light goes.
    radius : (n,) float32
    prim, strand : (n,) int64
        The number of the primitive, and the strand; -1 for none.
    """

    points: FloatArray
    normals: FloatArray
    tangents: FloatArray
    to_eye: FloatArray
    radius: FloatArray
    prim: IntArray
    strand: IntArray

    def __len__(self) -> int:
        return len(self.points)

    @classmethod
    def joined(cls, *parts: PathVertices) -> PathVertices:
        """Return all vertices of some parts, one part after another."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    def some(self, rows: npt.NDArray[np.bool_] | IntArray) -> PathVertices:
        """Return the vertices in some rows."""
        return PathVertices(*(getattr(self, field.name)[rows] for field in fields(self)))

    @property
    def h(self) -> FloatArray:
        """The offset of each ray from the axis of its fibre, in radii, as `fastlines.rendering.hair` counts it."""
        side = unit(np.cross(self.to_eye, self.tangents))
        return np.asarray(np.clip(dot(self.normals, side), -1, 1), np.float32)

    def exits(self, directions: FloatArray, extent: float) -> FloatArray:
        """Return how far rays in some directions are within the fibre that they start from, (n,).

        Examples
        --------
        >>> x, y = np.eye(3, dtype=np.float32)[:2, None]
        >>> numbers = np.zeros(1, np.int64), np.zeros(1, np.int64)
        >>> vertex = PathVertices(0.1 * y, y, x, y, np.full(1, 0.1, np.float32), *numbers)
        >>> [round(float(vertex.exits(way, 1.0)[0]), 3) for way in (y, -y, unit(x - y))]
        [0.002, 0.202, 0.285]
        """
        flat = is_zero(self.tangents)
        across = directions - dot(directions, self.tangents)[:, None] * self.tangents
        away = self.normals - dot(self.normals, self.tangents)[:, None] * self.tangents
        steep = np.maximum(dot(across, across), np.float32(STEEPEST**2))
        outwards = dot(away, across)
        rest = np.maximum(1 - dot(away, away), 0)
        chord = (np.sqrt(outwards**2 + steep * rest) - outwards) / steep
        return np.asarray(np.where(flat, 0, (chord + MARGIN) * self.radius) + LEAST * extent, np.float32)


def seen_vertices(fragments: Fragments, context: ShadingContext, across: FloatArray) -> PathVertices:
    """Return the vertices that rays from the camera see.

    Parameters
    ----------
    fragments : Fragments
        If they are of cones, each stands for the whole width of a fibre.
    context : ShadingContext
    across : (n,) floats
        The place on that width, from 0 to 1.
    """
    radius = _radius(fragments.hits, context)
    numbers = fragments.hits.prim_number, fragments.hits.strand
    if fragments.normals is not None:
        shape = fragments.points, fragments.normals, fragments.tangents, fragments.to_eye, radius
        return PathVertices(*shape, *numbers)
    h = 2 * across - 1
    sides = unit(np.cross(fragments.to_eye, fragments.tangents))
    facing = np.cross(fragments.tangents, sides)
    normals = unit(h[:, None] * sides + np.sqrt(np.maximum(1 - h**2, 0))[:, None] * facing)
    points = np.asarray(_on_axes(fragments.hits) + radius[:, None] * normals, np.float32)
    return PathVertices(points, normals, fragments.tangents, fragments.to_eye, radius, *numbers)


def hit_vertices(hits: AllHits, rays: IntArray, context: ShadingContext) -> PathVertices:
    """Return the vertices of hits at surfaces, each of one of the rays, whose directions have unit length."""
    assert hits.rays is not None
    normals = hits.normals()
    points = np.asarray(hits.points() + LEAST * context.extent * normals, np.float32)
    tangents = np.nan_to_num(hits.tangents()).astype(np.float32)
    to_eye = -hits.rays.directions[rays]
    shape = points, normals.astype(np.float32), tangents, to_eye, _radius(hits, context)
    return PathVertices(*shape, hits.prim_number, hits.strand)


def _radius(hits: AllHits, context: ShadingContext) -> FloatArray:
    own = hits.sample("radius") if context.tree.geometry.max_radius > 0 else np.zeros(hits.prim.shape)
    return np.asarray(np.nan_to_num(own) + context.radius, np.float32)


def _on_axes(hits: AllHits) -> npt.NDArray[np.float64]:
    """Return the points of the axes that were hit."""
    assert hits.geometry is not None
    return hits.geometry.axis_points(hits.prim, hits.u)
