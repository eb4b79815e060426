"""Checks the values of hits in float64: t, u and distance at the closest approach, entries and exits.

Where a line runs along a ray, t and u are not well defined, but these are:

- The ray's point at t is as far from the line's point at u as `distance` says.
- `distance` less the reach at u is the least D − R, up to the band of decisions.
- The points of entry and exit lie on the surface, or at a bound of the ray. Before the entry and after the exit, the
  ray is nowhere inside.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .exact import BAND, ExactRays, clearance_of_cones
from .exact_points import distance_from_cones, distance_from_triangles
from .scenes import Array, Random
from .values import Values

#: The most hits of a batch that are checked.
MOST_HITS = 2000
#: The bound of a place on a surface, as a multiple of the band of a decision.
OF_SURFACES = 2.0


@dataclass(frozen=True)
class Found:
    """Some hits of a query beside their rays in float64."""

    rays: ExactRays
    prim: Array
    #: Units of t in the unit of the scene, and the rounding of t in that unit, (n, 1) each.
    length: Array
    rounding: Array
    #: The columns of the answer in float64, (n,) each.
    columns: dict[str, Array]

    @staticmethod
    def of(rng: Random, hits: Any, rows: dict[str, Array], centre: Array) -> Found:
        """Return some hits of an answer."""
        names = [name for name in ("t", "u", "distance", "t_out") if getattr(hits, name) is not None]
        keep = np.sort(rng.permutation(len(hits.prim))[:MOST_HITS])
        ray = hits.ray[keep]
        columns = {name: getattr(hits, name)[keep].astype(np.float64) for name in names}
        length = np.sqrt((rows["directions"][ray].astype(np.float64) ** 2).sum(axis=1))
        largest = np.maximum(np.abs(columns["t"]), np.abs(columns.get("t_out", columns["t"])))
        rounding = np.spacing(largest.astype(np.float32)).astype(np.float64) * length
        rays = ExactRays.of({name: values[ray] for name, values in rows.items()}, centre)
        return Found(rays, hits.prim[keep], length[:, None], rounding[:, None], columns)

    def lengths(self, name: str) -> Array:
        """Return t or t_out as a length from the point nearest to the scene's centre, (n, 1)."""
        return self.columns[name][:, None] * self.length - self.rays.depth

    def points(self, name: str) -> Array:
        """Return the points of the rays there, (n, 3), relative to the centre of the scene."""
        return self.rays.at(self.lengths(name)[:, 0])


def check_closest(values: Values, kind: str, simd: str, found: Found, ends: Array, radii: Array, size: float) -> None:
    """Check t, u and distance of lines, round cones and spheres, whose rows of the hits these are."""
    rays, u = found.rays, found.columns["u"][:, None]
    place = ends[:, 0] + u * (ends[:, 1] - ends[:, 0])
    away = np.sqrt(((found.points("t") - place) ** 2).sum(axis=1, keepdims=True))
    depth = sum((place.T[k][:, None] - rays.origin[k]) * rays.direction[k] for k in range(3)) + rays.depth
    reach = radii[:, :1] + u * (radii[:, 1:] - radii[:, :1]) + rays.radius + rays.spread * depth
    distance = found.columns["distance"][:, None]
    bound = band_of(rays, size)
    values.check(f"{kind}, t and u", simd, away - distance, bound + found.rounding)
    least = clearance_of_cones(rays, ends, radii, is_paired=True)
    values.check(f"{kind}, distance", simd, distance - reach - least, bound)


def band_of(rays: ExactRays, size: float) -> Array:
    """Return the band of decisions about these rays, (n, 1)."""
    reach = np.maximum(rays.depth + 2 * size, 0) * rays.spread
    return np.asarray(BAND * (2 * size + rays.aside + rays.radius + reach) * (1 + rays.spread))


def check_surface(values: Values, kind: str, simd: str, found: Found, ends: Array, radii: Array, size: float) -> None:
    """Check entries and exits of lines, round cones and spheres."""
    rays, bound = found.rays, OF_SURFACES * band_of(found.rays, size) + found.rounding
    grown = radii + rays.radius
    for name, what, limit in (("t", "entry", rays.low), ("t_out", "exit", rays.high)):
        depth = distance_from_cones(found.points(name), ends, grown, is_paired=True)
        # A ray that starts or ends inside has its bound there, so its point may lie deep inside.
        is_bound = np.abs(found.lengths(name) - limit) <= found.rounding
        values.check(f"{kind}, {what}", simd, np.where(is_bound, np.maximum(depth, 0), depth), bound)
    gap = found.rounding + bound
    before = replace(rays, high=np.minimum(rays.high, found.lengths("t") - gap))
    after = replace(rays, low=np.maximum(rays.low, found.lengths("t_out") + gap))
    for part in (before, after):
        is_empty = part.low > part.high
        outside = clearance_of_cones(part, ends, radii, is_paired=True)
        values.check(f"{kind}, outside before and after", simd, np.where(is_empty, 0, np.minimum(outside, 0)), bound)


def check_shapes(values: Values, kind: str, simd: str, found: Found, corners: Array, size: float) -> None:
    """Check the places of hits on triangles and boxes."""
    rays, bound = found.rays, OF_SURFACES * band_of(found.rays, size) + found.rounding
    if kind == "triangles":
        away = distance_from_triangles(found.points("t"), corners, is_paired=True)
        values.check("triangles, t", simd, away, bound)
        return
    for name, what, limit in (("t", "entry", rays.low), ("t_out", "exit", rays.high)):
        x = found.points(name)
        beyond = np.maximum(corners[:, 0] - x, x - corners[:, 1]).max(axis=1, keepdims=True)  # negative inside
        is_bound = np.abs(found.lengths(name) - limit) <= found.rounding
        values.check(f"boxes, {what}", simd, np.where(is_bound, np.maximum(beyond, 0), beyond), bound)


def check_crossings(values: Values, simd: str, found: Found, geometry: Any, centre: Array, size: float) -> None:
    """Check that curves are entered and left on the surface of one of their pieces."""
    rays, bound = found.rays, OF_SURFACES * band_of(found.rays, size) + found.rounding
    pieces = geometry.straight
    ends, radii = pieces.segments.astype(np.float64) - centre, pieces.end_radii.astype(np.float64)
    is_own = geometry.owner[None] == found.prim[:, None]
    for name, what, limit in (("t", "entry", rays.low), ("t_out", "exit", rays.high)):
        depth = distance_from_cones(found.points(name), ends, radii) - rays.radius
        nearest = np.where(is_own, depth, np.inf).min(axis=1, keepdims=True)
        is_bound = np.abs(found.lengths(name) - limit) <= found.rounding
        values.check(f"curves, {what}", simd, np.where(is_bound, np.maximum(nearest, 0), nearest), bound)


def check_rays(
    values: Values, rng: Random, kind: str, simd: str, tree: Any, rows: dict[str, Array], centre: Array, size: float
) -> None:
    """Check the values of some hits of a batch of rays, by closest approach and at the surface."""
    geometry = tree.geometry
    has_spread = "spread" in rows
    if kind in ("triangles", "boxes"):
        found = Found.of(rng, tree.all_hits(**rows, at="surface"), rows, centre)
        check_shapes(values, kind, simd, found, geometry.corners[found.prim].astype(np.float64) - centre, size)
        return
    if kind == "curves":
        if not has_spread:
            hits = Found.of(rng, tree.all_hits(**rows, at="surface"), rows, centre)
            check_crossings(values, simd, hits, geometry, centre, size)
        return
    ends, radii = geometry.segments.astype(np.float64) - centre, geometry.end_radii.astype(np.float64)
    closest = Found.of(rng, tree.all_hits(**rows), rows, centre)
    name = f"{kind}, with a spread" if has_spread else kind
    check_closest(values, name, simd, closest, ends[closest.prim], radii[closest.prim], size)
    if not has_spread:
        surface = Found.of(rng, tree.all_hits(**rows, at="surface"), rows, centre)
        check_surface(values, kind, simd, surface, ends[surface.prim], radii[surface.prim], size)
