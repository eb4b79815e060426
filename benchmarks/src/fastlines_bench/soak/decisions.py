"""Checks decisions of the core, a ray or a point and a primitive each, against float64."""

from __future__ import annotations

from typing import Any

import numpy as np

import fastlines as fl

from .exact import BAND, ExactRays, clearance_of_cones, decide_boxes, decide_triangles
from .near_decisions import check_boxes, check_pairs, check_points, of_whole
from .parts import Part, part_over
from .ray_values import check_rays
from .rays import random_bounds, random_radii_of_rays, random_rays, random_spreads
from .scenes import SHAPES, Array, Random, random_axes
from .tally import Tally
from .trees import on

#: The kinds of geometry that are decided, and those that are decided for rays with a spread too.
DECIDED = ("lines", "cones", "spheres", "curves", "triangles", "boxes")
WITH_SPREAD = ("lines", "cones", "spheres", "curves")
#: Primitives and rays of a batch.
N_PRIMS, N_RAYS = 128, 1024
#: Rays whose decisions are computed at once, so that arrays stay in the cache.
ROWS = 64


def check_decisions(seed: int, number: int, kinds: tuple[str, ...] = DECIDED, n_rays: int = N_RAYS) -> Tally:
    """Decide for a random scene which rays hit which primitives, on every instruction set, and compare with float64.

    The decisions of the core are those of `Tree.all_hits`: a primitive that is not listed is missed. Those of half as
    many points are those of `Tree.within`; then there are pairs, and boxes of space. The values of hits are compared on
    one of the instruction sets.
    """
    rng = np.random.default_rng([seed, number, 1])
    kind = str(rng.choice([name for name in kinds if name in DECIDED]))
    shape = str(rng.choice(list(SHAPES)))
    ends = random_axes(rng, N_PRIMS if kind != "curves" else N_PRIMS // 8, shape)[1]
    part = part_over(rng, kind, ends)
    geometry = part.made()
    axes = ends.astype(np.float64)
    rows = random_rays(rng, axes, n_rays)
    size = float(np.ptp(np.asarray(geometry.bounds, np.float64), axis=0).max()) + 2 * geometry.max_radius or 1.0
    rows["radius"] = random_radii_of_rays(rng, n_rays, size)
    if rng.random() < 0.5:
        rows |= random_bounds(rng, axes, rows)
    has_spread = kind in WITH_SPREAD and rng.random() < 0.3
    if has_spread:
        rows["spread"] = random_spreads(rng, axes, rows)
    if kind in WITH_SPREAD and rng.random() < 0.6:
        _graze(rng, rows, geometry, size)
    tree = fl.build(geometry)
    try:
        found = {simd: _hits(tree, rows, simd, int(rng.integers(1, 3))) for simd in fl.available_simd()}
    except fl.InputError:
        return Tally(n_refused=1)
    name = f"{kind}, rays with a spread" if has_spread else f"{kind}, rays"
    tally = _compared(found, name, shape, part, geometry, rows, size)
    simd = str(rng.choice(fl.available_simd()))
    with on(simd, int(rng.integers(1, 3))):
        check_rays(
            tally.values, rng, kind, simd, tree, rows, np.asarray(geometry.bounds, np.float64).mean(axis=0), size
        )
    tally.add(check_points(rng, kind, shape, tree, axes, size, n_rays // 2))
    if kind in ("lines", "cones", "spheres"):
        tally.add(check_pairs(rng, kind, shape, geometry, size))
    if kind != "curves":
        tally.add(check_boxes(rng, kind, shape, tree, axes))
    return tally


def _graze(rng: Random, rows: dict[str, Array], geometry: Any, size: float) -> None:
    """Let the rays just touch a primitive, or pass it at up to twenty times the width of the band, in or out."""
    centre = np.asarray(geometry.bounds, np.float64).mean(axis=0)
    rows["radius"] = np.zeros(len(rows["origins"]), np.float32)
    for begin in range(0, len(rows["origins"]), ROWS):
        rays = ExactRays.of({key: values[begin : begin + ROWS] for key, values in rows.items()}, centre)
        clearance = _clearance(rays, geometry, centre)
        n = len(clearance)
        touching = clearance[np.arange(n), rng.integers(0, clearance.shape[1], n)]
        unit = 2 * size + rays.aside[:, 0] + np.maximum(touching, 0)
        aside = unit * BAND * rng.choice([0, 1, 20], n) * rng.uniform(-1, 1, n)
        rows["radius"][begin : begin + ROWS] = np.maximum(touching + aside, 0)


def _clearance(rays: ExactRays, geometry: Any, centre: Array) -> Array:
    """Return D − R of each ray and line, sphere or curve: of a curve, the least of its pieces."""
    lines = geometry.straight
    ends, radii = lines.segments.astype(np.float64) - centre, lines.end_radii.astype(np.float64)
    return of_whole(geometry, clearance_of_cones(rays, ends, radii))


def _hits(tree: Any, rows: dict[str, Any], simd: str, n_threads: int) -> Array:
    """Return whether each ray hits each primitive, (n_rays, n_prims) bool."""
    with on(simd, n_threads):
        hits = tree.all_hits(**rows)
    found = np.zeros((len(rows["origins"]), len(tree.geometry)), np.bool_)
    found[hits.ray, hits.prim] = True
    return found


def _compared(
    found: dict[str, Array], name: str, shape: str, part: Part, geometry: Any, rows: dict[str, Array], size: float
) -> Tally:
    tally = Tally()
    corners = np.asarray(geometry.bounds, np.float64)
    centre = corners.mean(axis=0)
    n_rays = len(rows["origins"])
    for begin in range(0, n_rays, ROWS):
        rays = ExactRays.of({key: values[begin : begin + ROWS] for key, values in rows.items()}, centre)
        is_hit, certain = _decide(rays, part.kind, geometry, centre, size)
        tally.n_in_band += int((~certain).sum())
        for simd, hits in found.items():
            tally.count((name, shape, simd), certain, hits[begin : begin + ROWS] != is_hit, begin)
    return tally


def _decide(rays: ExactRays, kind: str, geometry: Any, centre: Array, size: float) -> tuple[Array, Array]:
    """Return whether rays hit primitives in float64, and where that is certain."""
    unit = 2 * size + rays.aside
    if kind in ("triangles", "boxes"):
        corners = geometry.corners.astype(np.float64) - centre
        return (decide_triangles if kind == "triangles" else decide_boxes)(rays, corners, BAND * unit)
    clearance = _clearance(rays, geometry, centre)
    reach = np.maximum(rays.depth + 2 * size, 0) * rays.spread
    band = BAND * (unit + rays.radius + reach) * (1 + rays.spread)
    return clearance <= 0, np.abs(clearance) > band
