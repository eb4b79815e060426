"""Where hits are: their points on rays, and the normals there, in float64."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..geometry.hit_places import Float64Array, HitPlaces
from ..geometry.offsets import NO_OFFSET
from ..support.computed_once import computed_once
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

        With ``at="surface"`` it is where the ray enters the surface, computed in float64. The offset of the lines is
        added, so that the point has the coordinates that rays and files have.

        Parameters
        ----------
        outside : bool
            Move the points outwards along the normals, so that rays that start there and leave the surface do not hit
            it again; needs ``at="surface"``, and a ray that comes from outside. The distance is 2⁻²⁰ of the scene's
            longest side, its largest coordinate and the radius together.

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
        geometry, hits = self._known(), self._places()
        points = geometry.points_at(hits)
        if outside:
            self._require_surface()
            bounds = np.asarray(geometry.bounds, np.float64)
            size = float(np.ptp(bounds, axis=0).max() + np.abs(bounds).max()) if len(geometry) else 0.0
            distance = OUTSIDE * (size + geometry.radius_of(hits.prim) + hits.radius)
            points = points + distance[:, None] * self._outwards
        return self._filled(points if geometry.offset == NO_OFFSET else points + np.array(geometry.offset))

    def normals(self) -> Float64Array:
        """Return the unit normal of the surface at each point of entry, outwards, (…, 3) float64.

        For a ray that starts inside, it is the direction from the point of the axis at `u`, the centre of the ball in
        which the ray starts deepest. Where that is the point itself, it is opposite to the ray.

        Raises
        ------
        InputError
            If the query was not ``at="surface"``.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
        >>> print(tree.first_hit([0, 0, -5], [0, 0, 1], 0.5, at="surface").normals())
        [ 0.  0. -1.]
        """
        self._require_surface()
        return self._filled(self._outwards)

    @computed_once
    def _outwards(self) -> Float64Array:
        """The normal at each hit, without misses."""
        return self._known().normals_at(self._places())

    def _require_surface(self) -> None:
        """Refuse hits at the closest approach, unless nothing that was hit has an axis to approach."""
        if self.t_out is None and self._known().has_axes:
            raise InputError(
                "normals are those of a surface, and these hits are at the closest approach; query again with "
                "at='surface'"
            )

    def _ray_of_hits(self) -> IntArray:
        """Return the row of the ray of each hit, without misses."""
        raise NotImplementedError

    def _on_rays(self, prim: IntArray, u: Float64Array) -> HitPlaces:
        """See `FoundPrims`."""
        rays, row = self._known_rays(), self._ray_of_hits()
        t = self.t[self.prim >= 0]
        t_min, t_max = rays.scalar(rays.t_min, row), rays.scalar(rays.t_max, row)
        inside = (t != t_min) & (t != t_max)
        return HitPlaces(
            prim,
            u,
            t.astype(np.float64),
            rays.origins[row].astype(np.float64),
            rays.directions[row].astype(np.float64),
            rays.scalar(rays.radius, row).astype(np.float64),
            inside if self.t_out is not None else np.zeros(len(t), bool),
        )

    def _known_rays(self) -> RayBatch:
        if self.rays is None:
            raise InputError("these hits do not know their rays: a pickle leaves them out; query again")
        return self.rays.unchanged()
