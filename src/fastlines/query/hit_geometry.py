"""Where hits are: their points on rays, and the normals there, in float64."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import AnyArray, FloatArray, IntArray
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.hit_places import Float64Array, HitFrames, HitPlaces, HitRays
from ..geometry.offsets import NO_OFFSET
from .found_prims import FoundPrims
from .rays import RayBatch

#: How far outside a surface a ray has to start, so that the test of that surface, in float32, misses: as a fraction of
#: the scene's size, its largest coordinate and the radius together.
OUTSIDE = 2.0**-20


class HitGeometry(FoundPrims):
    """The geometry of hits: every array has their shape, and NaN for a miss."""

    skipped: IntArray
    t: FloatArray
    t_out: FloatArray | None
    rays: RayBatch | None

    _unpickled = ("geometry", "rays")

    def points(self, *, outside: bool = False) -> Float64Array:
        """Return the point of each hit on its ray, (…, 3) float64.

        Unless the query was ``at="closest"``, it is where the ray enters the surface, computed in float64. The offset
        of the lines is added, so that the point has the coordinates that rays and files have.

        Parameters
        ----------
        outside : bool
            Move the points outwards along the normals, so that rays that start there and leave the surface do not hit
            it again; needs ``at="surface"`` or ``at="entry"``, and a ray that comes from outside. The distance is 2⁻²⁰
            of the scene's longest side, its largest coordinate and the radius together.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build(fl.Lines.from_segments([[[-1, 0, 0], [1, 0, 0]]], radius=[0.5]))
        >>> hits = tree.first_hit([[0, 0, -5], [9, 9, 9]], [0, 0, 2], at="surface")
        >>> print(hits.points())
        [[ 0.   0.  -0.5]
         [ nan  nan  nan]]
        >>> tree.any_hit(hits.points(outside=True)[0], [1, 0, -1])
        array(False)
        """
        geometry = self._known()
        if outside:
            self._require_surface()
        points = self._at_places(True, _points_outside if outside else lambda of, places: of.points_at(places))
        return points if geometry.offset == NO_OFFSET else points + np.array(geometry.offset)

    def normals(self) -> Float64Array:
        """Return the unit normal of the surface at each point of entry, outwards, (…, 3) float64.

        For a ray that starts inside, it is the direction from the point of the axis at `u`, the centre of the ball in
        which the ray starts deepest. Where that is the point itself, it is opposite to the ray.

        Raises
        ------
        InputError
            If the query was ``at="closest"``, of lines or curves.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
        >>> print(tree.first_hit([0, 0, -5], [0, 0, 1], 0.5, at="surface").normals())
        [ 0.  0. -1.]
        """
        self._require_surface()
        return self._at_places(True, lambda geometry, places: geometry.normals_at(places))

    def frames(self, rows: IntArray | None = None, *, lift: float = 0.0) -> HitFrames:
        """Return points, normals, tangents, directions to the eye and radii of hits in float32, for shading.

        They are computed in float64 and then rounded. They are in the frame of the arrays of the geometry: its offset
        is not added. The arrays of the rays must not have changed since the query, which is not checked.

        Parameters
        ----------
        rows : (n,) int64, optional
            The rows of hits in the flattened answer, in any order; by default those of all hits.
        lift : float
            How far points are moved outwards along the normals.

        Raises
        ------
        InputError
            If the query was ``at="closest"``, of lines or curves.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build(fl.Lines.from_segments([[[-1, 0, 0], [1, 0, 0]]], radius=[0.5]))
        >>> frames = tree.first_hit([[9, 9, 9], [0, 0, -5]], [0, 0, 1], at="surface").frames(lift=0.25)
        >>> print(frames.points, frames.normals, frames.tangents, frames.radius)
        [[ 0.    0.   -0.75]] [[ 0.  0. -1.]] [[1. 0. 0.]] [0.5]
        """
        self._require_surface()
        places = self._places(misses=rows is not None)
        return self._known().frames_at(places if rows is None else places.some(rows), lift)

    def _require_surface(self) -> None:
        """Refuse hits at the closest approach, unless nothing that was hit has an axis to approach."""
        if self.t_out is None and self._known().has_axes:
            raise InputError(
                "normals are those of a surface, and these hits are at the closest approach; query again with "
                "at='surface' or at='entry'"
            )

    def _ray_of_rows(self) -> IntArray | None:
        """Return the row of the ray of each hit or miss; None if row i is of ray i."""
        raise NotImplementedError

    def _on_rays(self, prim: IntArray, u: Float64Array, rows: IntArray | None) -> HitPlaces:
        """See `FoundPrims`."""
        rays, t, ray = self._known_rays(), self.t.reshape(-1), self._ray_of_rows()
        if rows is not None:
            t, ray = t[rows], rows if ray is None else ray[rows]
        of_hits = HitRays(rays.origins, rays.directions, rays.radius, rays.t_min, rays.t_max)
        return HitPlaces(prim, u, t.astype(np.float64), of_hits, ray, self.t_out is not None)

    def _known_rays(self) -> RayBatch:
        if self.rays is None:
            raise InputError("these hits do not know their rays: a pickle leaves them out; query again")
        return self.rays.unchanged()


def _points_outside(geometry: AnyGeometry, places: HitPlaces) -> Float64Array:
    """Return points so far outside of the surfaces that rays from there do not hit these again."""
    return geometry.points_outside(places, outside_distance(geometry, geometry.radius_of(places.prim), places.radius))


def outside_distance(geometry: AnyGeometry, own: AnyArray | float, radius: AnyArray | float) -> Any:
    """Return how far outside surfaces rays have to start, for radii of their own and of the query."""
    bounds = np.asarray(geometry.bounds, np.float64)
    size = float(np.ptp(bounds, axis=0).max() + np.abs(bounds).max()) if len(geometry) else 0.0
    return OUTSIDE * (size + own + radius)
