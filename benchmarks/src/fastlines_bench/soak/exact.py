"""Whether rays hit primitives, in float64, and which of these decisions rounding to float32 may change.

A line or a round cone is hit where D(s) − R(s) ≤ 0 for some s (docs/answers.md). That function is convex, so its least
value is at an end of the axis, or where its derivative is 0 for the ray's line or for one of the ends of the ray. The
function is evaluated at all of these places, and the least value counts: so it does not matter which of them is the
closest approach. Triangles and boxes are as in textbooks.

Let size be the longest side of the scene with its radii, a the distance at which a ray passes the centre of the scene,
and ρ its largest reach there. A decision is in the *band* if the ray is within 2⁻²¹·(2·size + a + ρ) of the surface of
the primitive; with a spread κ, within 1 + κ times as much.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from .scenes import Array

#: Three coordinates, each an array that broadcasts.
Vector: TypeAlias = tuple[Any, Any, Any]

#: The width of the band, as a fraction of the numbers that go into a decision: 8 units in the last place of float32.
BAND = 2.0**-21


@dataclass(frozen=True)
class ExactRays:
    """Rays in float64 with unit directions, (m, 1) each: t is a length from the point nearest to the scene's centre."""

    origin: Vector
    direction: Vector
    low: Array
    high: Array
    radius: Array
    spread: Array
    #: The depth of t = 0 from the origin that was given, and the distance of the ray from the centre.
    depth: Array
    aside: Array

    @staticmethod
    def of(rows: dict[str, Array], centre: Array) -> ExactRays:
        """Return rays as questions have them, relative to the centre of the scene."""
        origins, directions = (rows[name].astype(np.float64) for name in ("origins", "directions"))
        n = len(origins)
        length = np.sqrt((directions**2).sum(axis=1))
        unit, away = directions / length[:, None], centre - origins
        depth = (away * unit).sum(axis=1)
        start = depth[:, None] * unit - away

        def column(values: Any) -> Array:
            return np.broadcast_to(np.asarray(values, np.float64), n).reshape(n, 1)

        with np.errstate(invalid="ignore"):
            low, high = (np.asarray(rows.get(name, bound), np.float64) * length - depth for name, bound in BOUNDS)
        return ExactRays(
            tuple(start.T[:, :, None]),
            tuple(unit.T[:, :, None]),
            column(low),
            column(high),
            column(rows["radius"]),
            column(rows.get("spread", 0.0)),
            column(depth),
            column(np.sqrt((start**2).sum(axis=1))),
        )

    def some(self, keep: Array) -> ExactRays:
        """Return these rays, in this order."""
        return self._each(lambda column: column[keep])

    def _each(self, change: Callable[[Array], Array]) -> ExactRays:
        (ox, oy, oz), (dx, dy, dz) = self.origin, self.direction
        rest = self.low, self.high, self.radius, self.spread, self.depth, self.aside
        origin, direction = (change(ox), change(oy), change(oz)), (change(dx), change(dy), change(dz))
        return ExactRays(origin, direction, *map(change, rest))

    def at(self, t: Array) -> Array:
        """Return the points at lengths t, (m,): (m, 3), relative to the centre of the scene."""
        return np.concatenate(plus(self.origin, t[:, None], self.direction), axis=1)


BOUNDS = (("t_min", 0.0), ("t_max", np.inf))


def dot(a: Vector, b: Vector) -> Array:
    """Return the scalar product."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def less(a: Vector, b: Vector) -> Vector:
    """Return a − b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def plus(a: Vector, s: Any, b: Vector) -> Vector:
    """Return a + s·b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def vectors(points: Array, is_paired: bool = False) -> Vector:
    """Return points, (n, 3), as (1, n) coordinates; as (n, 1) if each is paired with a row."""
    x, y, z = points.T[:, :, None] if is_paired else points.T[:, None]
    return x, y, z


def clearance_of_cones(rays: ExactRays, ends: Array, radii: Array, is_paired: bool = False) -> Array:
    """Return the least D − R of each ray and round cone, (m, n): negative where the ray is inside.

    Parameters
    ----------
    ends : (n, 2, 3) float64
        Relative to the centre of the scene.
    radii : (n, 2) float64
    is_paired : bool
        Whether ray i is paired with round cone i alone; then the answer is (n, 1).
    """
    p, e = vectors(ends[:, 0], is_paired), vectors(ends[:, 1] - ends[:, 0], is_paired)
    r0, r1 = (radii[:, i : i + 1] if is_paired else radii[None, :, i] for i in range(2))
    d = rays.direction
    w = less(p, rays.origin)
    along, e_along = dot(w, d), dot(e, d)
    slope = r1 - r0 + rays.spread * e_along
    reach0 = r0 + rays.radius + rays.spread * (along + rays.depth)
    ee, ww, we = dot(e, e), dot(w, w), dot(w, e)

    def value(s: Array) -> Array:
        """Return D − R at s; where R is negative there is no hit, and D − R is positive."""
        z = along + s * e_along
        t = np.minimum(np.maximum(z, rays.low), rays.high)
        x = plus(plus(w, s, e), -t, d)
        return np.asarray(np.sqrt(dot(x, x)) - (reach0 + s * slope))

    def stationary(length2: Array, we_: Array, ww_: Array) -> Array:
        """Return the s in [0, 1] at which |w + s·e| − R is stationary, for vectors with these products."""
        h2 = np.maximum(ww_ * length2 - we_ * we_, 0)
        rest = length2 - slope * slope
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (np.sqrt(h2 / np.maximum(rest, 0)) * slope - we_) / length2
        return np.where(np.isfinite(s), np.minimum(np.maximum(s, 0), 1), 0)

    least = np.minimum(value(np.zeros_like(along)), value(np.ones_like(along)))
    least = np.minimum(least, value(stationary(ee - e_along * e_along, we - along * e_along, ww - along * along)))
    for bound in (rays.low, rays.high):
        if np.isfinite(bound).any():
            t = np.where(np.isfinite(bound), bound, 0)
            s = stationary(ee + 0 * t, we - t * e_along, ww - 2 * t * along + t * t)
            least = np.minimum(least, value(s))
    return least


def decide_triangles(rays: ExactRays, corners: Array, band: Array) -> tuple[Array, Array]:
    """Return whether rays cross triangles, and where that is certain, (m, n) bool each."""
    points = [less(vectors(corners[:, i]), rays.origin) for i in range(3)]
    d = rays.direction
    a, b, c = points
    edges = [cross(points[i], points[(i + 1) % 3]) for i in range(3)]
    # The volumes that the ray spans with the edges have one sign inside.
    volumes = [dot(edge, d) for edge in edges]
    n = cross(less(b, a), less(c, a))
    facing = dot(n, d)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = dot(n, a) / facing
    inside = ((volumes[0] >= 0) & (volumes[1] >= 0) & (volumes[2] >= 0)) | (
        (volumes[0] <= 0) & (volumes[1] <= 0) & (volumes[2] <= 0)
    )
    is_hit = inside & (facing != 0) & (t >= rays.low) & (t <= rays.high)
    # It is certain if the ray passes all edges at a distance, and no end of the ray is near the triangle.
    nearest = np.full(facing.shape, np.inf)
    for i in range(3):
        p, e = points[i], less(points[(i + 1) % 3], points[i])
        nearest = np.minimum(nearest, _distance_from_line(p, e, d))
    certain = nearest > band
    for bound in (rays.low, rays.high):
        at = np.where(np.isfinite(bound), bound, 0.0)
        box = _distance_from_box(plus((0, 0, 0), at, d), points)
        certain &= ~np.isfinite(bound) | (box > band) | (_distance_from_plane(at, a, d, n) > band)
    return is_hit, certain


def _distance_from_line(p: Vector, e: Vector, d: Vector) -> Array:
    """Return the distance of the segment p + s·e from the line through 0 along the unit vector d."""
    along, e_along, ee = dot(p, d), dot(e, d), dot(e, e)
    length2, product = ee - e_along * e_along, dot(p, e) - along * e_along
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.minimum(np.maximum(-product / length2, 0), 1)
    found = np.full(np.shape(product), np.inf)
    for at in (0.0, 1.0, np.where(np.isfinite(s), s, 0)):
        x = plus(plus(p, at, e), -(along + at * e_along), d)
        found = np.minimum(found, np.sqrt(dot(x, x)))
    return found


def _distance_from_box(x: Vector, points: list[Vector]) -> Array:
    """Return a lower bound of the distance of points from triangles: that from their boxes."""
    sum2: Any = 0.0
    for k in range(3):
        low = np.minimum(np.minimum(points[0][k], points[1][k]), points[2][k])
        high = np.maximum(np.maximum(points[0][k], points[1][k]), points[2][k])
        sum2 = sum2 + np.maximum(np.maximum(low - x[k], x[k] - high), 0) ** 2
    return np.asarray(np.sqrt(sum2))


def _distance_from_plane(at: Array, a: Vector, d: Vector, n: Vector) -> Array:
    """Return the distance of the ray's point from the planes of triangles; 0 for those without a plane."""
    length = np.sqrt(dot(n, n))
    x = plus(a, -at, d)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.nan_to_num(np.abs(dot(x, n)) / length, nan=0.0, posinf=0.0))


def decide_boxes(rays: ExactRays, corners: Array, band: Array) -> tuple[Array, Array]:
    """Return whether rays hit boxes, and where that is certain: where boxes larger or smaller by the band agree."""
    exact, larger, smaller = (_hits_boxes(rays, corners, grow) for grow in (0.0 * band, band, -band))
    return exact, larger == smaller


def _hits_boxes(rays: ExactRays, corners: Array, grow: Array) -> Array:
    t_in, t_out = rays.low + 0 * grow, rays.high + 0 * grow
    empty = np.zeros((1, len(corners)), bool)
    for k in range(3):
        low, high = corners[None, :, 0, k] - grow, corners[None, :, 1, k] + grow
        o, d = rays.origin[k], rays.direction[k]
        with np.errstate(divide="ignore", invalid="ignore"):
            first, last = (low - o) / d, (high - o) / d
        outside = (d == 0) & ((o < low) | (o > high))
        across = d != 0
        t_in = np.maximum(t_in, np.where(across, np.minimum(first, last), -np.inf))
        t_out = np.minimum(t_out, np.where(across, np.maximum(first, last), np.inf))
        empty = empty | (low > high) | outside
    return np.asarray((t_in <= t_out) & ~empty)
