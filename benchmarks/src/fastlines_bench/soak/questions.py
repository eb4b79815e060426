"""Random questions about geometry: a query, its rays, points or boxes, and options that fit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import fastlines as fl

from .answers import PAIR_QUERIES, POINT_QUERIES, QUERIES, RAY_QUERIES
from .case import Question
from .parts import AXES, part_over
from .rays import random_bounds, random_boxes, random_points, random_radii_of_rays, random_rays, random_spreads
from .scenes import Array, Random, size_of

KERNELS = ("auto", "single", "wave", "bundle", "binary")
#: How many rays or points a question has, and how often; the largest number uses several threads.
COUNTS, SHARES = (1, 9, 45, 80, 400), (0.1, 0.2, 0.4, 0.2, 0.1)

#: The most that a hit or a pair takes while an answer in parts is made, with room to spare.
BYTES_A_ROW = 1000


@dataclass(frozen=True)
class Scene:
    """Geometry, and what questions need to know of it."""

    geometry: Any
    #: Lines through the primitives, (n, 2, 3) float64.
    ends: Array
    n_prims: int
    #: Whether it has pairs, and whether all of it has directions.
    has_pairs: bool
    has_directions: bool

    @property
    def size(self) -> float:
        """The longest side of the box of the scene."""
        return size_of(self.ends)

    def random_memory(self, rng: Random) -> int:
        """Return bytes that hold the hits of one ray, or the pairs of one primitive, or of many more."""
        return int(BYTES_A_ROW * max(1, len(self.geometry.core_rows)) * 10 ** rng.uniform(0, 2))


def queries_for(scene: Scene) -> tuple[str, ...]:
    """Return the queries that the geometry has."""
    left_out = () if scene.has_pairs else (*PAIR_QUERIES, "along")
    return tuple(name for name in QUERIES if name not in left_out)


def random_question(rng: Random, scene: Scene, query: str) -> Question:
    """Return a question."""
    n = int(rng.choice(COUNTS, p=SHARES))
    if query in RAY_QUERIES:
        rows, options = _rays(rng, scene, query, n)
    elif query in POINT_QUERIES:
        rows, options = _points(rng, scene, query, n)
    elif query == "in_box":
        rows, options = random_boxes(rng, scene.ends, min(n, 80)), {}
    elif query == "along":
        rows = {"points": _near(scene, random_points(rng, scene.ends, max(2, min(n, 9))))}
        options = {"radius": float(np.float32(scene.size * 10 ** rng.uniform(-4, 0.3)))}
    else:
        rows, options = {}, _pairs(rng, scene, query)
    if query in (*RAY_QUERIES, *POINT_QUERIES) and rng.random() < 0.15:
        _spoil(rng, rows)
        options["invalid"] = "skip"
    if query not in RAY_QUERIES and rng.random() < 0.5:
        options["to"] = str(rng.choice(["axis", "surface"]))
    n_threads = int(rng.integers(1, 5))
    kernel = str(rng.choice(KERNELS)) if query in RAY_QUERIES else "auto"
    # Draw one number whatever is installed, so that a seed makes the same cases.
    simd = fl.available_simd()[int(rng.random() * len(fl.available_simd()))]
    question = Question(query, rows, options, kernel, simd, n_threads)
    if query in PAIR_QUERIES and rng.random() < 0.3:
        near = scene.ends + rng.normal(0, 0.05 * scene.size, scene.ends.shape)
        options.pop("skip_strand", None)
        question = replace(question, other=part_over(rng, str(rng.choice(AXES)), near[:40].astype(np.float32)))
    return question


def _pairs(rng: Random, scene: Scene, query: str) -> dict[str, Any]:
    options: dict[str, Any] = {"radius": float(np.float32(scene.size * rng.choice([0, 1e-3, 0.02, 0.1, 3])))}
    if query == "iter_pairs":
        options["max_bytes"] = scene.random_memory(rng)
    if rng.random() < 0.4:
        options["skip_neighbours"] = int(rng.integers(0, 4))
    if rng.random() < 0.2:
        options["skip_strand"] = True
    return options


def _near(scene: Scene, points: Array) -> Array:
    """Return points within the size of the scene, whose polyline is not cut."""
    corners = scene.ends.reshape(-1, 3) if len(scene.ends) else np.zeros((1, 3))
    return np.clip(points, corners.min(axis=0) - scene.size, corners.max(axis=0) + scene.size)


def _rays(rng: Random, scene: Scene, query: str, n: int) -> tuple[dict[str, Array], dict[str, Any]]:
    rows = random_rays(rng, scene.ends, n)
    rows["radius"] = random_radii_of_rays(rng, n, scene.size)
    if rng.random() < 0.5:
        rows |= random_bounds(rng, scene.ends, rows)
    options: dict[str, Any] = {}
    at = "closest"
    if query not in ("first_surface", "gather") and rng.random() < 0.5:
        at = "entry" if query in ("any_hit", "count_hits") else str(rng.choice(["surface", "entry"]))
    elif scene.geometry.takes_spread and query != "first_surface" and rng.random() < 0.4:
        rows["spread"] = random_spreads(rng, scene.ends, rows)
    if at != "closest":
        options["at"] = at
    if rng.random() < 0.3 and at == "closest" and "spread" not in rows and query != "gather":
        _touch(rng, scene, rows)
    _leave_out(rng, scene, rows, options)
    match query:
        case "next_hits":
            options |= {"k": int(rng.choice([1, 2, 3, 7, 40])), "rank": str(rng.choice(["t", "distance"]))}
        case "all_hits" | "iter_all_hits":
            if at == "surface" and rng.random() < 0.4:
                options["merge"] = "strand"
            if query == "iter_all_hits":
                options["max_bytes"] = scene.random_memory(rng)
        case "gather":
            _sum(rng, scene, rows, options)
    return rows, options


def _touch(rng: Random, scene: Scene, rows: dict[str, Array]) -> None:
    """Let radii be those at which rays just touch a primitive, or one unit in the last place more or less."""
    if not isinstance(scene.geometry, fl.Lines) or not len(scene.geometry) or scene.geometry.offset != (0, 0, 0):
        return
    asked: dict[str, Any] = {**rows, "radius": np.full(len(rows["origins"]), 0.3 * scene.size, np.float32)}
    try:
        hits = fl.brute_force(scene.geometry, **asked)
    except fl.InputError:  # the scene is so small that the radius is too large for it
        return
    own = hits.sample("radius") if scene.geometry.radius is not None else np.zeros(len(hits))
    touching = np.maximum(hits.distance - own, 0).astype(np.float32)
    rows["radius"] = rows["radius"].copy()
    for ray in np.flatnonzero(hits.counts):
        radius = touching[hits.offsets[ray] + rng.integers(hits.counts[ray])]
        aside = [radius, np.nextafter(radius, np.float32(np.inf)), np.nextafter(radius, np.float32(0))]
        rows["radius"][ray] = max(aside[int(rng.integers(3))], np.float32(0))


def _spoil(rng: Random, rows: dict[str, Array]) -> None:
    """Make some rays or points such that they can not be asked: NaN, infinite, too far away, or without a direction."""
    name = str(rng.choice([name for name in ("origins", "directions", "points") if name in rows]))
    values, n = rows[name].copy(), len(rows[name])
    for row in rng.permutation(n)[: int(rng.integers(1, 2 + n // 4))]:
        if name == "directions" and rng.random() < 0.3:
            values[row] = 0
        else:
            values[row, rng.integers(3)] = rng.choice([np.nan, np.inf, -np.inf, 1e35])
    rows[name] = values


def _leave_out(rng: Random, scene: Scene, rows: dict[str, Array], options: dict[str, Any]) -> None:
    """Leave out primitives, strands or parts, of some questions."""
    n = len(next(iter(rows.values())))
    if scene.n_prims and rng.random() < 0.2:
        if rng.random() < 0.5:
            rows["ignore"] = rng.integers(-1, scene.n_prims, (n, 3))
        else:
            options["ignore"] = rng.integers(-1, scene.n_prims, 4)
    if scene.geometry.n_strands > 1 and rng.random() < 0.2:
        options["ignore_strands"] = rng.integers(-1, scene.geometry.n_strands, 2)
    if scene.geometry.has_parts and rng.random() < 0.3:
        options["parts"] = np.unique(rng.integers(0, len(scene.geometry.parts), 2))


def _sum(rng: Random, scene: Scene, rows: dict[str, Array], options: dict[str, Any]) -> None:
    """Choose what is summed."""
    options["blur"] = str(rng.choice(["box", "epanechnikov", "none"])) if scene.has_directions else "none"
    if options["blur"] != "none":
        rows["radius"] = np.maximum(rows["radius"], np.float32(1e-6 * scene.size))
    channels = int(rng.integers(1, 4))
    if rng.random() < 0.7:
        options["channels"] = channels
    if rng.random() < 0.5:
        options["sigma"] = float(10 ** rng.uniform(-2, 1) / scene.size)
    for name, value in (("phase", 0.5), ("inner", False), ("squares", True)):
        if rng.random() < 0.4 and (name != "phase" or scene.has_directions):
            options[name] = value


def _points(rng: Random, scene: Scene, query: str, n: int) -> tuple[dict[str, Array], dict[str, Any]]:
    rows, options = {"points": random_points(rng, scene.ends, n)}, {}
    radius = random_radii_of_rays(rng, n, scene.size)
    if query == "nearest":
        options["k"] = int(rng.choice([1, 1, 2, 5, 50]))
        if rng.random() < 0.5:
            rows["max_distance"] = radius
    else:
        rows["radius"] = radius
    _leave_out(rng, scene, rows, options)
    return rows, options
