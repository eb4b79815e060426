"""Where hits are: points, normals and tangents in float64, and attributes at the place of each hit."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .arrays import FloatArray, IntArray, did_you_mean
from .errors import InputError
from .lines import Lines
from .rays import RayBatch
from .surface import enter_round_cones

Float64Array = npt.NDArray[np.float64]

#: How far outside a surface a ray has to start, so that the test of that surface, in float32, misses: as a fraction of
#: the scene's size, its largest coordinate and the radius together.
OUTSIDE = 2.0**-20


class HitGeometry:
    """The geometry of hits: every array has their shape, and NaN for a miss."""

    t: FloatArray
    prim: IntArray
    u: FloatArray
    t_out: FloatArray | None
    lines: Lines | None
    rays: RayBatch | None

    def points(self, *, outside: bool = False) -> Float64Array:
        """Return the point of each hit on its ray, (…, 3) float64.

        With ``at="surface"`` it is where the ray enters the surface, computed in float64.

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
        points, s = self._points()
        if outside:
            lines, rays = self._known_lines(), self._known_rays()
            size = float(np.ptp(lines.bounds, axis=0).max() + np.abs(lines.bounds).max()) if len(lines) else 0.0
            reach = lines.end_radii[self.prim[self.prim >= 0]].max(axis=1, initial=0.0)
            distance = OUTSIDE * (size + reach + rays.scalar(rays.radius, self._ray_of_hits()))
            points = points + distance[:, None] * self._outwards(points, s)
        return self._filled(points)

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
        return self._filled(self._outwards(*self._points()))

    def _outwards(self, points: Float64Array, s: Float64Array) -> Float64Array:
        """Return the unit normals at the points of all hits but misses; `s` is their place on the axis."""
        if self.t_out is None:
            raise InputError(
                "normals are those of a surface, and these hits are at the closest approach; query again with "
                "at='surface'"
            )
        start, edge = self._axes()
        outwards = points - (start + s[:, None] * edge)
        centred = ~outwards.any(axis=1)
        outwards[centred] = -self._known_rays().directions[self._ray_of_hits()[centred]]
        return _unit(outwards)

    def tangents(self) -> Float64Array:
        """Return the unit vector from start to end of each segment that was hit, (…, 3) float64.

        It is NaN for a segment of length zero.

        Examples
        --------
        >>> import fastlines as fl
        >>> print(fl.build([[[-1, 0, 0], [1, 0, 0]]]).first_hit([0, 0, -5], [0, 0, 1], 0.5).tangents())
        [1. 0. 0.]
        """
        return self._filled(_unit(self._axes()[1]))

    def sample(self, name: str) -> npt.NDArray[Any]:
        """Return an attribute of the lines, or their radius, at each hit; NaN for a miss.

        What is known at both ends of a segment is interpolated at `u`; whole numbers and booleans are those of the
        nearer end. What is known for the whole segment is constant. Numbers become float64.

        Parameters
        ----------
        name : str
            A key of `Lines.attributes` or `Lines.end_attributes`, or "radius".

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = fl.Lines.from_points([[0, 0, 0], [1, 0, 0]], [2], attributes={"fa": [0.0, 1.0]})
        >>> fl.build(lines).first_hit([[0.25, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5).sample("fa")
        array([0.25,  nan])
        """
        lines, hit = self._known_lines(), self.prim >= 0
        prim, u = self.prim[hit], self.u[hit].astype(np.float64)
        at_ends = dict(lines.end_attributes) | ({} if lines.radius is None else {"radius": lines.end_radii})
        if name not in at_ends and name not in lines.attributes:
            known = dict.fromkeys([*at_ends, *lines.attributes])
            raise InputError(f"name={name!r} is no attribute of these lines{did_you_mean(name, known)}")
        values = at_ends[name] if name in at_ends else lines.attributes[name]
        if values.dtype.kind not in "fiub":
            raise InputError(
                f"{name!r} holds {values.dtype}, expected numbers; index the attribute with hits.prim[hits.hit]"
            )
        if name not in at_ends:
            return self._filled(values[prim])
        first, last = np.moveaxis(values[prim], 1, 0)
        weight = u.reshape(-1, *[1] * (first.ndim - 1))
        if values.dtype.kind != "f":
            return self._filled(np.where(weight < 0.5, first, last))
        return self._filled((1 - weight) * first + weight * last)

    def _known_lines(self) -> Lines:
        if self.lines is None:
            raise InputError(
                "these hits do not know their lines: a pickle has `row` and `strand` in their place; query again"
            )
        return self.lines

    def _ray_of_hits(self) -> IntArray:
        """Return the row of the ray of each hit that is no miss."""
        raise NotImplementedError

    def _filled(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return values of all hits as float64 in the shape of the answer, NaN for misses."""
        filled = np.full((*self.prim.shape, *values.shape[1:]), np.nan)
        filled[self.prim >= 0] = values
        return filled

    def _axes(self) -> tuple[Float64Array, Float64Array]:
        """Return the start of each segment that was hit, and its end − start."""
        ends = self._known_lines().segments[self.prim[self.prim >= 0]].astype(np.float64)
        return ends[:, 0], ends[:, 1] - ends[:, 0]

    def _points(self) -> tuple[Float64Array, Float64Array]:
        """Return the point of each hit that is no miss, and its place on the axis."""
        lines, hit = self._known_lines(), self.prim >= 0
        rays = self._known_rays()
        row = self._ray_of_hits()
        origins, directions = (part[row].astype(np.float64) for part in (rays.origins, rays.directions))
        t, s = self.t[hit].astype(np.float64), self.u[hit].astype(np.float64)
        if self.t_out is not None:
            # Intersect the surface in float64, except where a bound of the ray cut it off.
            start, edge = self._axes()
            radii = (
                np.zeros((len(s), 2)) if lines.radius is None else lines.end_radii[self.prim[hit]].astype(np.float64)
            )
            radii += rays.scalar(rays.radius, row)[:, None]
            exact, at = enter_round_cones(start, edge, radii[:, 0], radii[:, 1] - radii[:, 0], origins, directions)
            free = (self.t[hit] != rays.scalar(rays.t_min, row)) & (self.t[hit] != rays.scalar(rays.t_max, row))
            use = free & np.isfinite(exact)
            t, s = np.where(use, exact, t), np.where(use, at, s)
        return origins + t[:, None] * directions, s

    def _known_rays(self) -> RayBatch:
        if self.rays is None:
            raise InputError("these hits do not know their rays: a pickle leaves them out; query again")
        return self.rays.unchanged()


def _unit(vectors: Float64Array) -> Float64Array:
    with np.errstate(invalid="ignore"):
        return np.asarray(vectors / np.sqrt((vectors**2).sum(axis=-1, keepdims=True)))
