"""Checks decisions of the core, a ray or a point and a primitive each, against float64."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import fastlines as fl

from .exact import BAND, ExactRays, clearance_of_cones, decide_boxes, decide_triangles
from .exact_points import POINT_BAND, distance_from_boxes, distance_from_cones, distance_from_triangles
from .parts import Part, part_over
from .rays import random_bounds, random_points, random_radii_of_rays, random_rays, random_spreads
from .scenes import SHAPES, Array, Random, random_axes
from .trees import on

#: The kinds of geometry that are decided, and those that are decided for rays with a spread too.
DECIDED = ("lines", "cones", "spheres", "curves", "triangles", "boxes")
WITH_SPREAD = ("lines", "cones", "spheres", "curves")
#: Primitives and rays of a batch.
N_PRIMS, N_RAYS = 128, 1024
#: Rays whose decisions are computed at once, so that arrays stay in the cache.
ROWS = 64


@dataclass
class Tally:
    """Decisions outside the band, and how many of them are wrong, by shape, scene and instruction set."""

    n: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    wrong: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    n_in_band: int = 0
    #: Batches whose rays the tree refuses.
    n_refused: int = 0
    #: The first wrong decisions, in words.
    examples: list[str] = field(default_factory=list)

    def count(self, key: tuple[str, str, str], certain: Array, differs: Array, first: int) -> None:
        """Count certain decisions of rays or points from the first one on, and those that differ."""
        wrong = certain & differs
        self.n[key] += int(certain.sum())
        self.wrong[key] += int(wrong.sum())
        for row, prim in np.argwhere(wrong)[:1]:
            self.examples.append(f"{', '.join(key)}: row {first + row}, primitive {prim}")

    def add(self, other: Tally) -> None:
        """Add the counts of another tally."""
        self.n.update(other.n)
        self.wrong.update(other.wrong)
        self.n_in_band += other.n_in_band
        self.n_refused += other.n_refused
        self.examples += other.examples[: max(0, 10 - len(self.examples))]


def check_decisions(seed: int, number: int, kinds: tuple[str, ...] = DECIDED, n_rays: int = N_RAYS) -> Tally:
    """Decide for a random scene which rays hit which primitives, on every instruction set, and compare with float64.

    The decisions of the core are those of `Tree.all_hits`: a primitive that is not listed is missed. Those of half as
    many points are those of `Tree.within`.
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
    try:
        found = {simd: _hits(geometry, rows, simd, int(rng.integers(1, 3))) for simd in fl.available_simd()}
    except fl.InputError:
        return Tally(n_refused=1)
    name = f"{kind}, rays with a spread" if has_spread else f"{kind}, rays"
    tally = _compared(found, name, shape, part, geometry, rows, size)
    tally.add(_check_points(rng, kind, shape, geometry, axes, size, n_rays // 2))
    return tally


def _check_points(rng: Random, kind: str, shape: str, geometry: Any, axes: Array, size: float, n_points: int) -> Tally:
    """Decide which primitives are within a radius of points; some radii just reach a primitive."""
    centre = np.asarray(geometry.bounds, np.float64).mean(axis=0)
    points = random_points(rng, axes, n_points)
    exact = _distances(points - centre, kind, geometry, centre)
    radius = random_radii_of_rays(rng, n_points, size)
    touched = rng.random(n_points) < 0.5
    place = exact[np.arange(n_points), rng.integers(0, exact.shape[1], n_points)]
    aside = POINT_BAND * (size + np.abs(place)) * rng.choice([0, 1, 20], n_points) * rng.uniform(-1, 1, n_points)
    radius[touched] = np.maximum(place + aside, 0)[touched]
    is_within, band = exact <= radius[:, None], POINT_BAND * (size + np.abs(exact))
    certain = np.abs(exact - radius[:, None]) > band
    tally = Tally(n_in_band=int((~certain).sum()))
    for simd in fl.available_simd():
        try:
            with on(simd, int(rng.integers(1, 3))):
                within = fl.build(geometry).within(points, radius)
        except fl.InputError:
            return Tally(n_refused=1)
        found = np.zeros(exact.shape, np.bool_)
        found[within.point, within.prim] = True
        tally.count((f"{kind}, points", shape, simd), certain, found != is_within, 0)
    return tally


def _distances(points: Array, kind: str, geometry: Any, centre: Array) -> Array:
    """Return the distances of points from primitives, or from surfaces, relative to the centre of the scene."""
    if kind in ("triangles", "boxes"):
        corners = geometry.corners.astype(np.float64) - centre
        return (distance_from_triangles if kind == "triangles" else distance_from_boxes)(points, corners)
    lines = geometry.straight
    ends, radii = lines.segments.astype(np.float64) - centre, lines.end_radii.astype(np.float64)
    return _of_whole(geometry, distance_from_cones(points, ends, radii))


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
    return _of_whole(geometry, clearance_of_cones(rays, ends, radii))


def _of_whole(geometry: Any, of_rows: Array) -> Array:
    """Return the values of primitives, from those of rows of the core: of a curve, the least of its pieces."""
    if not geometry.in_pieces:
        return of_rows
    first = np.flatnonzero(np.diff(geometry.owner, prepend=-1))
    return np.asarray(np.minimum.reduceat(of_rows, first, axis=1))


def _hits(geometry: Any, rows: dict[str, Any], simd: str, n_threads: int) -> Array:
    """Return whether each ray hits each primitive, (n_rays, n_prims) bool."""
    with on(simd, n_threads):
        hits = fl.build(geometry).all_hits(**rows)
    found = np.zeros((len(rows["origins"]), len(geometry)), np.bool_)
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
