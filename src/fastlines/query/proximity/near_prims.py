"""Where primitives are nearest to the points of a query: in float64, with attributes there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import IntArray
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...geometry.hit_places import Float64Array, HitPlaces, HitRays
from ...geometry.offsets import NO_OFFSET
from ..found_prims import FoundPrims
from .points import PointBatch


class NearPrims(FoundPrims):
    """Primitives near to points: every array has their shape, and NaN for a miss."""

    skipped: IntArray
    query_points: PointBatch | None

    _unpickled = ("geometry", "query_points")

    def points(self) -> Float64Array:
        """Return the nearest point of each primitive, (…, 3) float64; the offset of the lines is added.

        It is computed again in float64. Of lines, it is the point of the axis at `u`. With ``to="surface"``, it is the
        point of the surface in the direction of the query point; if that lies on the axis, in a direction across it. Of
        a triangle it is the nearest point, and of a box too, which is the query point itself if it is inside.

        Raises
        ------
        InputError
            If a class of your own does not return a "point"; or if the answer comes from a pickle.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build(fl.Lines.from_segments([[[-1, 0, 0], [1, 0, 0]]], radius=[0.5]))
        >>> print(tree.nearest([0.25, 0, 3]).points(), tree.nearest([0.25, 0, 3], to="axis").points())
        [0.25 0.   0.5 ] [0.25 0.   0.  ]
        """
        geometry = self._known()
        points = self._nearest(geometry, self._from_points())
        return self._filled(points if geometry.offset == NO_OFFSET else points + np.array(geometry.offset))

    def _point_of_found(self) -> IntArray:
        """Return the position of the query point of each primitive, without misses."""
        raise NotImplementedError

    def _from_points(self) -> HitPlaces:
        """Return what was found, with rays that begin at the query points and end there."""
        if self.query_points is None:
            raise InputError("this answer does not know its points: a pickle leaves them out; query again")
        origins = self.query_points.points[self.query_points.row(self._point_of_found())]
        found = self._places(on_rays=False)
        return replace(found, t=np.zeros(len(found.prim)), rays=HitRays.of_points(origins))

    def _nearest(self, geometry: AnyGeometry, places: HitPlaces) -> Float64Array:
        assert self.query_points is not None
        return geometry.nearest_at(places, self.query_points.surface)

    def _on_rays(self, prim: IntArray, u: Float64Array, rows: IntArray | None) -> HitPlaces:
        """Return rays that begin at the nearest points."""
        places = self._from_points()
        return replace(places, rays=HitRays.of_points(self._nearest(self._known(), places)))
