"""Nasty inputs, made from a seed: scenes and rays that break a careless tree, layout or exact test.

Every scene is shown a mixture of all kinds of rays; each kind of ray and each window on t also has a case of its own.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import fastlines as fl

Array = npt.NDArray[Any]
Random = np.random.Generator


class Case(NamedTuple):
    """One question: segments, rays, and the radii to ask it with (each a number or one per ray)."""

    segments: Array
    origins: Array
    directions: Array
    radii: dict[str, Any]
    t_min: Any = 0.0
    t_max: Any = np.inf


# ---- Scenes: (n, 2, 3) float64 of about unit size ----


def random(rng: Random, n: int) -> Array:
    start = rng.uniform(-1, 1, (n, 3))
    return np.stack([start, start + rng.normal(0, 0.2, (n, 3))], axis=1)


def crossing(rng: Random, n: int) -> Array:
    """Long lines from side to side, as spaghetti."""
    ends = rng.uniform(-1, 1, (n, 2, 3))
    axis = rng.integers(0, 3, n)
    ends[np.arange(n), 0, axis], ends[np.arange(n), 1, axis] = -1, 1
    return ends


def hair(rng: Random, n: int) -> Array:
    """Strands of eight short steps; ends are shared."""
    steps = np.array([0, 0, 0.1]) + rng.normal(0, 0.03, (n // 8, 9, 3))
    points = rng.uniform(-1, 1, (n // 8, 1, 3)) * [1, 1, 0] + np.cumsum(steps, axis=1)
    return np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)


def star(rng: Random, n: int) -> Array:
    """All through one point, half of them ending there: the light of photon beams."""
    ends = np.stack([np.zeros((n, 3)), rng.normal(0, 0.5, (n, 3))], axis=1)
    ends[::2, 0] = -ends[::2, 1]
    return ends + np.array([0.25, 0.5, -0.125])


def star_at_zero(rng: Random, n: int) -> Array:
    """Here floats let boxes shrink to 1e-38 around the point."""
    return star(rng, n) - np.array([0.25, 0.5, -0.125])


def equal_boxes(rng: Random, n: int) -> Array:
    """The four diagonals of one box, either way round: no box tells them apart."""
    sign = rng.choice([-1.0, 1.0], (n, 3))
    return np.stack([sign, -sign], axis=1) * [1, 0.7, 0.4]


def axis_parallel(rng: Random, n: int) -> Array:
    """A lattice: many equal coordinates, flat boxes, shared planes."""
    start = rng.integers(-4, 5, (n, 3)) / 4
    step = np.zeros((n, 3))
    step[np.arange(n), rng.integers(0, 3, n)] = rng.integers(-4, 5, n) / 4
    return np.stack([start, start + step], axis=1)


def collinear(rng: Random, n: int) -> Array:
    """All on the x axis, overlapping: boxes of no area."""
    ends = np.zeros((n, 2, 3))
    ends[..., 0] = rng.uniform(-1, 1, (n, 2))
    return ends


def flat(rng: Random, n: int) -> Array:
    return crossing(rng, n) * [1, 1, 0]


def thin(rng: Random, n: int) -> Array:
    """Flat but for heights between 1e-30 and 1e-3: an extent that only floats know."""
    heights = rng.choice([0.0, 1e-30, 1e-18, 1e-9, 1e-6, 1e-3], (n, 2)) * rng.choice([-1, 1], (n, 2))
    ends = crossing(rng, n)
    ends[..., 2] = heights
    return ends


def duplicates(rng: Random, n: int) -> Array:
    few = crossing(rng, max(1, n // 6))
    ends = few[rng.integers(0, len(few), n)]
    turned = rng.random(n) < 0.3
    ends[turned] = ends[turned, ::-1]
    return ends


def points(rng: Random, n: int) -> Array:
    """Segments of length zero, some of them at one place."""
    place = rng.uniform(-1, 1, (n, 1, 3))
    place[: n // 3] = place[0]
    return np.repeat(place, 2, axis=1)


def some_points(rng: Random, n: int) -> Array:
    ends = crossing(rng, n)
    ends[::3, 1] = ends[::3, 0]
    return ends


def nearly_points(rng: Random, n: int) -> Array:
    """A few ulps long."""
    start = rng.uniform(-1, 1, (n, 3))
    return np.stack([start, start + rng.integers(-3, 4, (n, 3)) * 2.0**-24], axis=1)


def single(rng: Random, n: int) -> Array:
    return crossing(rng, 1)


def single_point(rng: Random, n: int) -> Array:
    return points(rng, 1)


def empty(rng: Random, n: int) -> Array:
    return np.empty((0, 2, 3))


def outlier(rng: Random, n: int) -> Array:
    """A small bundle, and one line that makes the scene a thousand times larger."""
    ends = random(rng, n)
    ends[0] *= 1000
    return ends


def moved_by(distance: float) -> Callable[[Random, int], Array]:
    def moved(rng: Random, n: int) -> Array:
        return crossing(rng, n) + distance * rng.choice([-1.0, 1.0], 3)

    return moved


def hair_moved_by(distance: float) -> Callable[[Random, int], Array]:
    def moved(rng: Random, n: int) -> Array:
        return hair(rng, n) + distance * np.array([1, -1, 0.3])

    return moved


def scaled_by(scale: float) -> Callable[[Random, int], Array]:
    def scaled(rng: Random, n: int) -> Array:
        return np.concatenate([random(rng, n // 2), crossing(rng, n - n // 2)]) * scale

    return scaled


# ---- Rays: origins and directions for a scene ----


def targets(rng: Random, ends: Array, n: int, miss: float) -> Array:
    """Points on the segments, or within `miss` of them."""
    if len(ends) == 0:
        return rng.uniform(-1, 1, (n, 3))
    p, q = ends[rng.integers(0, len(ends), n)].swapaxes(0, 1)
    s = rng.choice([0.0, 1.0, 0.5, *rng.random(5)], (n, 1))
    return p + s * (q - p) + rng.normal(0, 1, (n, 3)) * miss * rng.choice([0, 1e-3, 0.1, 1], (n, 1))


def sphere(rng: Random, n: int) -> Array:
    v = rng.normal(0, 1, (n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def from_distance(distance: float) -> Callable[..., tuple[Array, Array]]:
    """Rays from outside, aimed at the segments and beside them."""

    def rays(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
        directions = sphere(rng, n)
        return targets(rng, ends, n, size) - directions * distance * size, directions

    return rays


def from_inside(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    return targets(rng, ends, n, size / 3), sphere(rng, n)


def along_axes(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    """Directions with one or two components of zero, of either sign, or all but zero."""
    directions = sphere(rng, n)
    nothing = rng.choice([0.0, -0.0, 1e-30, -1e-12, 1e-7], (n, 3))
    directions = np.where(rng.random((n, 3)) < 0.6, nothing, directions)
    empty_ones = np.abs(directions).max(axis=1) < 1e-3
    directions[empty_ones, rng.integers(0, 3, empty_ones.sum())] = rng.choice([-1.0, 1.0], empty_ones.sum())
    return targets(rng, ends, n, size) - directions * 3 * size, directions


def along_segments(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    """Rays that run along a segment, exactly or nearly, on it or beside it, either way."""
    if len(ends) == 0:
        return from_inside(rng, ends, n, size)
    p, q = ends[rng.integers(0, len(ends), n)].swapaxes(0, 1)
    e = np.where((p == q).all(axis=1, keepdims=True), size * sphere(rng, n), q - p)
    tilt = rng.choice([0, 0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3], (n, 1))
    beside = rng.choice([0, 0, 1e-7, 1e-4, 1e-3, 0.05], (n, 1))
    start = rng.choice([-2.0, -1.0, 0.0, 0.25, 1.0, 1.5], (n, 1))
    length = np.linalg.norm(e, axis=1, keepdims=True)
    directions = (e + tilt * length * sphere(rng, n)) * rng.choice([-1, 1], (n, 1))
    unit = rng.random((n, 1)) < 0.5
    return p + start * e + beside * size * sphere(rng, n), np.where(unit, directions / length, directions)


def from_segments(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    return targets(rng, ends, n, 0), sphere(rng, n)


def not_unit(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    origins, directions = from_distance(1)(rng, ends, n, size)
    return origins, directions * 10 ** rng.uniform(-3, 3, (n, 1))


def passing_far(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    """Rays that never come near: the scene's radius from a few to 10⁶ sizes away."""
    directions = sphere(rng, n)
    aside = np.cross(directions, sphere(rng, n)) * size * 10 ** rng.uniform(0, 6, (n, 1))
    return targets(rng, ends, n, size) + aside - directions * size, directions


RAYS: dict[str, Callable[..., tuple[Array, Array]]] = {
    "rays outside": from_distance(3),
    "rays inside": from_inside,
    "rays 1e3 away": from_distance(1e3),
    "rays 1e5 away": from_distance(1e5),
    "rays along axes": along_axes,
    "rays along segments": along_segments,
    "rays on segments": from_segments,
    "rays not unit": not_unit,
    "rays passing far": passing_far,
}

SCENES: dict[str, Callable[[Random, int], Array]] = {
    "random": random,
    "crossing": crossing,
    "hair": hair,
    "star": star,
    "star at zero": star_at_zero,
    "equal boxes": equal_boxes,
    "axis parallel": axis_parallel,
    "collinear": collinear,
    "flat": flat,
    "thin": thin,
    "duplicates": duplicates,
    "points": points,
    "some points": some_points,
    "nearly points": nearly_points,
    "single": single,
    "single point": single_point,
    "empty": empty,
    "outlier": outlier,
    "scale 1e-8": scaled_by(1e-8),
    "scale 1e8": scaled_by(1e8),
    "moved 1e2": moved_by(1e2),
    "moved 1e4": moved_by(1e4),
    "hair moved 1e5": hair_moved_by(1e5),
}


def mixed(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    parts = [rays(rng, ends, -(-n // len(RAYS)), size) for rays in RAYS.values()]
    return np.concatenate([o for o, _ in parts])[:n], np.concatenate([d for _, d in parts])[:n]


def size_of(segments: Array) -> float:
    """The longest side of the scene; 1 if it has none."""
    if len(segments) == 0:
        return 1.0
    corners = segments.reshape(-1, 3).astype(np.float64)
    return float((corners.max(axis=0) - corners.min(axis=0)).max()) or 1.0


def radii_for(rng: Random, size: float, n_rays: int) -> dict[str, Any]:
    per_ray = size * 10 ** rng.uniform(-6, 0.7, n_rays)
    per_ray[rng.random(n_rays) < 0.15] = 0
    return {
        "zero": 0.0,
        "small": 1e-3 * size,
        "medium": 0.05 * size,
        "larger than the scene": 3 * size,
        "per ray": per_ray.astype(np.float32),
    }


def spreads(case: Case, n_rays: int, seed: int) -> Array:
    """Return one spread a ray: none, some of any size, and some that make the reach about the size of the scene."""
    rng = np.random.default_rng(seed)
    found = 10.0 ** rng.uniform(-5, 0.7, n_rays)
    away = np.linalg.norm(case.origins.astype(np.float64), axis=1).max() + size_of(case.segments)
    tuned = rng.random(n_rays) < 0.5
    found[tuned] *= size_of(case.segments) / away
    found[rng.random(n_rays) < 0.2] = 0
    return found.astype(np.float32)


def windows_for(rng: Random, ends: Array, origins: Array, directions: Array) -> dict[str, tuple[Any, Any]]:
    """Bounds on t, some at and around where the ray passes a segment."""
    n = len(origins)
    length2 = (directions.astype(np.float64) ** 2).sum(axis=1)
    passes = ((targets(rng, ends, n, 0) - origins) * directions).sum(axis=1) / length2
    width = np.abs(rng.normal(0, 0.3, n)) / np.sqrt(length2)
    mixed_low = np.where(rng.random(n) < 0.3, -np.inf, passes - width * rng.choice([0, 0.1, 1], n))
    mixed_high = np.where(rng.random(n) < 0.3, np.inf, passes + width * rng.choice([0, 0.1, 1], n))
    return {
        "window around a hit": (passes - width, passes + width),
        "window to a hit": (-np.inf, passes),
        "window from a hit": (passes, np.inf),
        "window of a point": (passes, passes),
        "window of all the line": (-np.inf, np.inf),
        "window behind": (-np.inf, 0.0),
        "window per ray": (mixed_low, mixed_high),
        "window beyond": (passes + 10 * width, np.inf),
    }


def cases(seed: int, n_segments: int = 40, n_rays: int = 45) -> dict[str, Case]:
    """Return the catalogue for one seed."""

    def random_for(name: str) -> Random:
        return np.random.default_rng([seed, zlib.crc32(name.encode())])

    def case(name: str, scene: Callable[..., Array], rays: Callable[..., tuple[Array, Array]]) -> Case:
        rng = random_for(name)
        segments = scene(rng, n_segments).astype(np.float32)
        size = size_of(segments)
        origins, directions = rays(rng, segments.astype(np.float64), n_rays, size)
        origins, directions = origins.astype(np.float32), directions.astype(np.float32)
        return Case(segments, origins, directions, radii_for(rng, size, n_rays))

    found = {name: case(name, scene, mixed) for name, scene in SCENES.items()}
    found |= {name: case(name, crossing, rays) for name, rays in RAYS.items()}
    base = case("windows", crossing, mixed)
    ends = base.segments.astype(np.float64)
    for name, (low, high) in windows_for(random_for("windows again"), ends, base.origins, base.directions).items():
        found[name] = base._replace(t_min=np.float32(low), t_max=np.float32(high))
    return found


#: The names of all cases, for parametrised tests.
NAMES = tuple(cases(0, 8, 9))


def named_scene(name: str, n: int = 40) -> Any:
    """Make a scene that is the same every time."""
    return SCENES[name](np.random.default_rng(zlib.crc32(name.encode())), n).astype(np.float32)


def triangles_on(ends: Any) -> fl.Triangles:
    """Give each segment a third corner."""
    third = ends[:, :1] + np.random.default_rng(1).normal(0, 0.3, (len(ends), 1, 3)).astype(np.float32)
    return fl.Triangles(np.concatenate([ends, third], axis=1))


def boxes_of(ends: Any) -> fl.Boxes:
    """Bound each segment."""
    return fl.Boxes(np.stack([ends.min(axis=1), ends.max(axis=1)], axis=1))


def same(a: fl.Tree, b: fl.Tree) -> bool:
    """Tell whether two trees are the same, bit for bit."""
    return a.nodes.tobytes() == b.nodes.tobytes() and a.refs.tobytes() == b.refs.tobytes()
