"""Where rays hit primitives, as a kind of geometry gets it: one hit a row, in float64."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..support.computed_once import computed_once
from ..support.vectors import dot, is_zero

Float64Array = npt.NDArray[np.float64]


class HitRays(NamedTuple):
    """The rays of hits: origins and directions (m, 3); radius, t_min and t_max (m,), or (1,) for all."""

    origins: npt.NDArray[Any]
    directions: npt.NDArray[Any]
    radius: npt.NDArray[Any]
    t_min: npt.NDArray[Any]
    t_max: npt.NDArray[Any]

    @classmethod
    def of_points(cls, points: Float64Array) -> HitRays:
        """Return rays that begin at points and end there."""
        zero = np.zeros(1)
        return cls(points, np.zeros(points.shape), zero, zero, zero)


class HitFrames(NamedTuple):
    """What shading reads of hits, one row a hit: float32, computed in float64.

    Attributes
    ----------
    points : (n, 3) float32
        Moved outwards along the normals.
    normals : (n, 3) float32
        Unit vectors, outwards.
    tangents : (n, 3) float32
        Unit vectors along the axes; zero where there is none.
    to_eye : (n, 3) float32
        The directions of the rays, backwards.
    radius : (n,) float32
        Of the primitive, 0 if it has none, and of the ray together.
    """

    points: FloatArray
    normals: FloatArray
    tangents: FloatArray
    to_eye: FloatArray
    radius: FloatArray


@dataclass(frozen=True, eq=False)
class HitPlaces:
    """Hits and their rays, one row for each hit.

    Attributes
    ----------
    prim : (n,) int64
        The primitives. Misses, -1, are among them only for geometry that `takes_misses`.
    u, t : (n,) float64
        The places on the primitives, and on the rays.
    rays : HitRays or None
        None if they are unknown.
    ray : (n,) int64 or None
        The row of the ray of each hit; None if hit i is of ray i.
    at_surface : bool
        Whether t is where a ray enters a surface, or a bound of the ray if it starts inside.
    """

    prim: IntArray
    u: Float64Array
    t: Float64Array
    rays: HitRays | None = None
    ray: IntArray | None = None
    at_surface: bool = True

    @classmethod
    def without_rays(cls, prim: IntArray, u: Float64Array) -> HitPlaces:
        """Return hits whose rays are unknown."""
        return cls(prim, u, np.full(len(prim), np.nan))

    def some(self, rows: IntArray) -> HitPlaces:
        """Return the hits in some rows."""
        return replace(
            self, prim=self.prim[rows], u=self.u[rows], t=self.t[rows], ray=rows if self.ray is None else self.ray[rows]
        )

    @computed_once
    def origins(self) -> Float64Array:
        """The origin of each ray, (n, 3)."""
        return self._of_rays("origins")

    @computed_once
    def directions(self) -> Float64Array:
        """The direction of each ray, (n, 3)."""
        return self._of_rays("directions")

    @property
    def radius(self) -> Float64Array:
        """The radius of each ray, (n,)."""
        return self._of_rays("radius")

    @property
    def enters(self) -> npt.NDArray[np.bool_]:
        """Whether each ray enters a surface at t, (n,). It does not if it starts inside, so that t is a bound."""
        inside: npt.NDArray[np.bool_] = (self.t != self._of_rays("t_min")) & (self.t != self._of_rays("t_max"))
        return inside & self.at_surface

    def _of_rays(self, name: str) -> Float64Array:
        """Return a column of the rays, one row a hit, in float64."""
        assert self.rays is not None
        values = getattr(self.rays, name)
        if len(values) == 1:
            return np.broadcast_to(values.astype(np.float64), (len(self.prim), *values.shape[1:]))
        return np.asarray(values if self.ray is None else values[self.ray], np.float64)

    def on_rays(self) -> Float64Array:
        """Return the points on the rays."""
        return np.asarray(self.origins + self.t[:, None] * self.directions)

    def entering_at(self, exact: Float64Array) -> HitPlaces:
        """Return the hits with a t computed again, where it is finite and the ray enters a surface."""
        return replace(self, t=np.where(self.enters & np.isfinite(exact), exact, self.t))

    def outwards(self, away: Float64Array) -> Float64Array:
        """Return unit normals, from vectors of any length; where these are zero, against the rays."""
        centred = is_zero(away)
        away[centred] = -self.directions[centred]
        return unit(away)


def unit(vectors: Float64Array) -> Float64Array:
    """Return unit vectors; NaN for those of length zero."""
    with np.errstate(invalid="ignore"):
        return np.asarray(vectors / np.sqrt(dot(vectors, vectors))[..., None] + 0.0)  # no negative zeros


def perpendicular(vectors: Float64Array) -> Float64Array:
    """Return vectors, not of length zero, across unit vectors; any for those that are NaN."""
    vectors = np.where(np.isnan(vectors), [0.0, 0.0, 1.0], vectors)
    axis = np.zeros(vectors.shape)
    axis[np.arange(len(axis)), np.abs(vectors).argmin(axis=1)] = 1
    return np.cross(vectors, axis)


def interpolate(values: npt.NDArray[Any], weights: Float64Array) -> npt.NDArray[Any]:
    """Return the mean of values at the k ends or corners of each primitive, (n, k, …), by weights (n, k).

    Whole numbers and booleans are those of the largest weight, of two equal ones the latter.
    """
    if values.dtype.kind != "f":
        last = weights.shape[1] - 1
        return np.asarray(values[np.arange(len(values)), last - weights[:, ::-1].argmax(axis=1)])
    return np.asarray((weights.reshape(*weights.shape, *[1] * (values.ndim - 2)) * values).sum(axis=1))


def require_numbers(name: str, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Refuse an attribute that does not hold numbers."""
    if values.dtype.kind not in "fiub":
        raise InputError(
            f"{name!r} holds {'texts or objects' if values.dtype.kind in 'OUS' else values.dtype}, expected numbers; "
            "index the attribute with hits.prim, where that is not -1"
        )
    return values
