"""What a kind of geometry answers about hits on it: where they are, and which way surfaces and axes run there."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..arrays import AnyArray, FloatArray, IntArray
from ..errors import InputError
from .hit_places import Float64Array, HitPlaces


class HitAnswers:
    """The answers of a kind without axes; see `AnyGeometry`."""

    @property
    def has_axes(self) -> bool:
        """Whether hits may be at a closest approach to an axis, not at a surface."""
        return False

    #: Whether points, normals and tangents are those of misses, too: NaN.
    takes_misses: ClassVar[bool] = False

    def points_at(self, hits: HitPlaces) -> Float64Array:
        """Return the point of each hit on its ray; where the ray enters a surface, t is computed again in float64."""
        return hits.on_rays()

    def points_outside(self, hits: HitPlaces, distance: Float64Array) -> Float64Array:
        """Return the points moved outwards along the normals, each by its distance."""
        return np.asarray(self.points_at(hits) + distance[:, None] * self.normals_at(hits))

    def nearest_at(self, hits: HitPlaces, surface: bool) -> Float64Array:
        """Return the point of each primitive, or of its surface if it has a radius, that is nearest to an origin."""
        raise InputError(f"{type(self).__name__} have no nearest points")

    def normals_at(self, hits: HitPlaces) -> Float64Array:
        """Return the outward unit normal at each hit."""
        raise InputError(f"{type(self).__name__} have no normals")

    def tangents_at(self, hits: HitPlaces) -> Float64Array:
        """Return the unit vector along the axis at each hit; NaN for what has none."""
        return np.full((len(hits.prim), 3), np.nan)

    @property
    def has_directions(self) -> bool:
        """Whether any primitive is a line or a curve, which runs in a direction."""
        return False

    def lines_at(self, prim: IntArray, u: FloatArray) -> FloatArray:
        """Return the line at each hit: both ends, and the radius at each, (n, 8) float32; zeros for what has none.

        Of a curve it is the unit tangent, from zero, with the radius at the hit.
        """
        return np.zeros((len(prim), 8), np.float32)

    def axis_points(self, prim: IntArray, u: AnyArray) -> Float64Array:
        """Return the points of the axes at places u; NaN for what has none."""
        return np.full((len(prim), 3), np.nan)
