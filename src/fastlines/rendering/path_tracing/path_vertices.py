"""Where paths of light scatter: points at the surface of fibres and of other shapes."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...query.hits import AllHits, FirstHits
from ...support.vectors import unit
from ..shading.fragments import Fragments
from ..shading.shading_context import ShadingContext

#: How far outside a surface a ray starts at least, as a fraction of the scene's extent.
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
    def columns(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """The columns that compiled scattering takes."""
        return self.points, self.normals, self.tangents, self.to_eye, self.radius


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


def hit_vertices(hits: FirstHits | AllHits, rows: IntArray, context: ShadingContext) -> PathVertices:
    """Return the vertices of some hits at surfaces, of rays whose directions have unit length."""
    prim = hits.prim_number[rows]
    frames = hits.frames(rows, lift=LEAST * context.extent)
    return PathVertices(*frames, prim, context.tree.geometry.strands_of(prim))


def _radius(hits: AllHits, context: ShadingContext) -> FloatArray:
    own = hits.sample("radius") if context.tree.geometry.max_radius > 0 else np.zeros(hits.prim.shape)
    return np.asarray(np.nan_to_num(own) + context.radius, np.float32)


def _on_axes(hits: AllHits) -> npt.NDArray[np.float64]:
    """Return the points of the axes that were hit."""
    assert hits.geometry is not None
    return hits.geometry.axis_points(hits.prim, hits.u)
