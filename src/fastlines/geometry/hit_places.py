"""Where rays hit primitives, as a kind of geometry gets it: one hit a row, in float64."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..errors import InputError
from ..support.vectors import dot, is_zero

Float64Array = npt.NDArray[np.float64]


class HitPlaces(NamedTuple):
    """Hits and their rays: one row for each hit, without misses."""

    prim: IntArray
    u: Float64Array
    t: Float64Array
    origins: Float64Array
    directions: Float64Array
    radius: Float64Array
    #: Whether the ray enters a surface at t. It does not if it starts inside, so that t is a bound of the ray.
    enters: npt.NDArray[np.bool_]

    @classmethod
    def without_rays(cls, prim: IntArray, u: Float64Array) -> HitPlaces:
        """Return hits whose rays are unknown (NaN)."""
        unknown = np.full(len(prim), np.nan)
        vectors = np.full((len(prim), 3), np.nan)
        return cls(prim, u, unknown, vectors, vectors, unknown, np.zeros(len(prim), bool))

    def some(self, rows: Any) -> HitPlaces:
        """Return the hits in some rows."""
        return HitPlaces(*(column[rows] for column in self))

    def on_rays(self) -> Float64Array:
        """Return the points on the rays."""
        return np.asarray(self.origins + self.t[:, None] * self.directions)

    def entering_at(self, exact: Float64Array) -> HitPlaces:
        """Return the hits with a t computed again, where it is finite and the ray enters a surface."""
        return self._replace(t=np.where(self.enters & np.isfinite(exact), exact, self.t))

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
