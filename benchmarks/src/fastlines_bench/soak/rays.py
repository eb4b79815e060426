"""Random rays, points and boxes for a scene, of the kinds where rounding decides."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from .scenes import Array, Random, size_of

#: A function that aims n rays at axes, (m, 2, 3) float64, of a scene of some size: origins and directions.
Aim: TypeAlias = Callable[[Random, Array, int, float], tuple[Array, Array]]


def targets(rng: Random, ends: Array, n: int, miss: float) -> Array:
    """Return points on axes, or within about `miss` of them."""
    if len(ends) == 0:
        return rng.uniform(-1, 1, (n, 3))
    p, q = ends[rng.integers(0, len(ends), n)].swapaxes(0, 1)
    s = rng.choice([0.0, 1.0, 0.5, *rng.random(5)], (n, 1))
    return np.asarray(p + s * (q - p) + rng.normal(0, 1, (n, 3)) * miss * rng.choice([0, 1e-3, 0.1, 1], (n, 1)))


def unit_vectors(rng: Random, n: int) -> Array:
    """Return isotropic directions."""
    v = rng.normal(0, 1, (n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))


def _from_distance(distance: float) -> Aim:
    def aim(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
        directions = unit_vectors(rng, n)
        return targets(rng, ends, n, size) - directions * distance * size, directions

    return aim


def _inside(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    return targets(rng, ends, n, size / 3), unit_vectors(rng, n)


def _along_axes(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    """Aim along coordinate axes: components of zero of either sign, or all but zero."""
    directions = unit_vectors(rng, n)
    nothing = rng.choice([0.0, -0.0, 1e-30, -1e-12, 1e-7], (n, 3))
    directions = np.where(rng.random((n, 3)) < 0.6, nothing, directions)
    empty = np.abs(directions).max(axis=1) < 1e-3
    directions[empty, rng.integers(0, 3, empty.sum())] = rng.choice([-1.0, 1.0], empty.sum())
    return targets(rng, ends, n, size) - directions * 3 * size, directions


def _along_lines(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    """Aim along lines of the scene, exactly or nearly, on them or beside them, either way."""
    if len(ends) == 0:
        return _inside(rng, ends, n, size)
    p, q = ends[rng.integers(0, len(ends), n)].swapaxes(0, 1)
    e = np.where((p == q).all(axis=1, keepdims=True), size * unit_vectors(rng, n), q - p)
    tilt = rng.choice([0, 0, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3], (n, 1))
    beside = rng.choice([0, 0, 1e-7, 1e-4, 1e-3, 0.05], (n, 1))
    start = rng.choice([-2.0, -1.0, 0.0, 0.25, 1.0, 1.5], (n, 1))
    length = np.linalg.norm(e, axis=1, keepdims=True)
    directions = (e + tilt * length * unit_vectors(rng, n)) * rng.choice([-1, 1], (n, 1)) / length
    return p + start * e + beside * size * unit_vectors(rng, n), directions


def _from_lines(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    return targets(rng, ends, n, 0), unit_vectors(rng, n)


def _far_beside(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    directions = unit_vectors(rng, n)
    aside = np.cross(directions, unit_vectors(rng, n)) * size * 10 ** rng.uniform(0, 6, (n, 1))
    return targets(rng, ends, n, size) + aside - directions * size, directions


def _picture(rng: Random, ends: Array, n: int, size: float) -> tuple[Array, Array]:
    """Aim the rays of a picture, which are coherent: from one point, or parallel."""
    view, aim = unit_vectors(rng, 1)[0], targets(rng, ends, 1, size / 3)[0]
    side = max(1, int(np.sqrt(n)))
    u = np.cross(view, [0.3, 0.7, 0.2])
    v = np.cross(view, u)
    grid = (np.arange(n) % side - side / 2)[:, None] * u + (np.arange(n) // side - side / 2)[:, None] * v
    grid *= size * 10 ** rng.uniform(-3, 0.3) / side
    eye = aim - view * size * rng.choice([0.1, 3.0, 100.0])
    if rng.random() < 0.5:
        return eye + grid, np.broadcast_to(view, (n, 3)).copy()
    towards = aim + grid - eye
    return np.broadcast_to(eye, (n, 3)).copy(), towards / np.linalg.norm(towards, axis=1, keepdims=True)


AIMS: dict[str, Aim] = {
    "outside": _from_distance(3),
    "inside": _inside,
    "1e3 away": _from_distance(1e3),
    "1e5 away": _from_distance(1e5),
    "along axes": _along_axes,
    "along lines": _along_lines,
    "on lines": _from_lines,
    "far beside": _far_beside,
}


def random_rays(rng: Random, ends: Array, n: int) -> dict[str, Array]:
    """Return origins and directions, float32: of one kind, of all, or of a picture; some directions are not unit."""
    size = size_of(ends)
    kind = rng.random()
    if kind < 0.3:
        origins, directions = _picture(rng, ends, n, size)
    elif kind < 0.6:
        origins, directions = list(AIMS.values())[rng.integers(len(AIMS))](rng, ends, n, size)
    else:
        each = [aim(rng, ends, -(-n // len(AIMS)), size) for aim in AIMS.values()]
        origins, directions = (np.concatenate(arrays)[:n] for arrays in zip(*each, strict=True))
    if rng.random() < 0.3:
        directions = directions * 10 ** rng.uniform(-3, 3, (n, 1))
    return {"origins": origins.astype(np.float32), "directions": directions.astype(np.float32)}


def random_radii_of_rays(rng: Random, n: int, size: float) -> Array:
    """Return a radius for each ray, float32: one for all, or some of all sizes, with zeros."""
    if rng.random() < 0.5:
        return np.full(n, size * rng.choice([0.0, 1e-3, 0.05, 0.05, 3.0]), np.float32)
    each = size * 10 ** rng.uniform(-6, 0.7, n)
    each[rng.random(n) < 0.15] = 0
    return each.astype(np.float32)


def random_bounds(rng: Random, ends: Array, rays: dict[str, Array]) -> dict[str, Array]:
    """Return bounds on t, some at and around where the rays pass a line of the scene."""
    origins, directions = (rays[name].astype(np.float64) for name in ("origins", "directions"))
    n, length2 = len(origins), (directions**2).sum(axis=1)
    passes = ((targets(rng, ends, n, 0) - origins) * directions).sum(axis=1) / length2
    width = size_of(ends) * np.abs(rng.normal(0, 0.3, n)) / np.sqrt(length2)
    low = np.where(rng.random(n) < 0.3, -np.inf, passes - width * rng.choice([0, 0.1, 1], n))
    high = np.where(rng.random(n) < 0.3, np.inf, passes + width * rng.choice([0, 0.1, 1], n))
    return {"t_min": low.astype(np.float32), "t_max": high.astype(np.float32)}


def random_spreads(rng: Random, ends: Array, rays: dict[str, Array]) -> Array:
    """Return a spread for each ray: none, any, or one that makes the reach about the size of the scene."""
    n, size = len(rays["origins"]), size_of(ends)
    found = 10.0 ** rng.uniform(-5, 0.7, n)
    away = np.linalg.norm(rays["origins"].astype(np.float64) - (ends.reshape(-1, 3)[:1] if len(ends) else 0), axis=1)
    tuned = rng.random(n) < 0.5
    found[tuned] *= size / (away.max() + size)
    found[rng.random(n) < 0.2] = 0
    return found.astype(np.float32)


def random_points(rng: Random, ends: Array, n: int) -> Array:
    """Return points on lines, at their joints, near them and far away, (n, 3) float64; most are no float32."""
    size = size_of(ends)
    near, on = targets(rng, ends, n, size), targets(rng, ends, n, 0)
    away = on + unit_vectors(rng, n) * size * 10.0 ** rng.choice([0, 0.5, 3, 6], (n, 1))
    kind = rng.choice(4, n, p=[0.5, 0.2, 0.15, 0.15])[:, None]
    joints = ends.reshape(-1, 3)[rng.integers(0, 2 * len(ends), n)] if len(ends) else on
    return np.asarray(np.select([kind == 0, kind == 1, kind == 2], [near, on, joints], away))


def random_boxes(rng: Random, ends: Array, n: int) -> dict[str, Any]:
    """Return boxes of all sizes with corners at ends of lines; some are points, or have infinite sides."""
    points = ends.reshape(-1, 3) if len(ends) else np.zeros((1, 3))
    start = points[rng.integers(len(points), size=n)]
    reach = size_of(ends) * 10.0 ** rng.uniform(-5, 0.5, (n, 1)) * rng.random((n, 3))
    other = np.where(rng.random((n, 1)) < 0.4, points[rng.integers(len(points), size=n)], start + reach)
    other[::8] = start[::8]
    low, high = np.minimum(start, other), np.maximum(start, other)
    low[1::8, rng.integers(3)] = -np.inf
    high[2::8, rng.integers(3)] = np.inf
    return {"low": low, "high": high}
