"""Where rays enter and leave round cones, if they are aimed at tips, ends and apexes, against the definition."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import fastlines as fl

#: How far a point of entry may lie from the surface, in a scene of size 1.
TOLERANCE = 5e-6


def clearance(lines: fl.Lines, prim: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return how far points are from the surfaces of round cones; negative inside."""
    start, end = np.moveaxis(lines.segments[prim].astype(np.float64), 1, 0)
    radius, radius1 = lines.end_radii[prim].astype(np.float64).T
    edge, slope, offset = end - start, radius1 - radius, points - start
    length = np.sqrt((edge**2).sum(axis=1))
    along = (offset * edge).sum(axis=1) / length**2
    across = np.sqrt(((offset - along[:, None] * edge) ** 2).sum(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        side = along + across * slope / (length * np.sqrt(np.maximum(length**2 - slope**2, 0)))
    places = np.stack([np.zeros(len(prim)), np.ones(len(prim)), np.clip(np.nan_to_num(side), 0, 1)])
    gaps = [np.sqrt(((offset - s[:, None] * edge) ** 2).sum(axis=1)) - radius - s * slope for s in places]
    return np.asarray(np.min(gaps, axis=0))


def deepest(f: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return where a convex function is least, by a search by thirds."""
    for _ in range(44):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        left = f(a) < f(b)
        low, high = np.where(left, low, a), np.where(left, b, high)
    return (low + high) / 2


def check(lines: fl.Lines, origins: np.ndarray, directions: np.ndarray) -> int:
    """Check all hits of rays, whose directions are of unit length; return how many there are."""
    hits = fl.build(lines).all_hits(origins, directions, at="surface")
    o, d = origins[hits.ray].astype(np.float64), directions[hits.ray].astype(np.float64)

    def at(t: np.ndarray) -> np.ndarray:
        return clearance(lines, hits.prim, o + t[:, None] * d)

    t_in, t_out = hits.t.astype(np.float64), hits.t_out.astype(np.float64)
    middle = deepest(at, np.zeros(len(t_in)), np.full(len(t_in), 8.0))
    grazes = at(middle) > -TOLERANCE
    # The ray is on the surface there, outside before the entry, and outside after the exit.
    assert np.abs(at(t_in)).max() < TOLERANCE
    assert np.abs(at(t_out)).max() < TOLERANCE
    assert ((t_in <= middle) | grazes).all()
    assert ((t_out >= middle) | grazes).all()
    # Points are computed in float64.
    points = hits.points()
    deep = at(middle) < -1e-4
    assert np.abs(clearance(lines, hits.prim, points)[deep]).max() < 1e-7
    assert ((points - o) * d).sum(axis=1)[deep] == pytest.approx(t_in[deep], abs=1e-2)
    # u is the place of a ball that the ray touches.
    start, end = np.moveaxis(lines.segments[hits.prim].astype(np.float64), 1, 0)
    u = hits.u[:, None]
    radius = (lines.end_radii[hits.prim] * np.concatenate([1 - u, u], axis=1)).sum(axis=1)
    gap = np.sqrt(((o + t_in[:, None] * d - start - u * (end - start)) ** 2).sum(axis=1)) - radius
    assert gap.max() < TOLERANCE
    return len(hits)


def unit(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(vectors / np.sqrt((vectors**2).sum(axis=-1, keepdims=True)))


#: The radii of both ends, as a fraction of the length of the axis.
RADII: dict[str, tuple[float, float]] = {
    "a tip": (0.3, 0),
    "a wide tip": (0.9, 0),
    "a hair": (1e-3, 0),
    "a tip of 1e-7": (0.2, 1e-7),
    "a tip of 1e-6": (0.2, 1e-6),
    "a tip of 1e-5": (0.6, 1e-5),
    "an apex beyond the end": (0.3, 0.1),
    "nearly a ball": (0.99999, 0),
    "nearly a ball within a ball": (1.3, 0.300001),
    "a ball": (1.1, 0.05),
    "a capsule": (0.1, 0.1),
}


@pytest.mark.parametrize("name", RADII)
def test_rays_aimed_at_ends_meet_the_surface(name: str) -> None:
    rng = np.random.default_rng(list(RADII).index(name))
    n, n_rays = 24, 1000
    start = rng.random((n, 3)).astype(np.float32)
    end = (start + unit(rng.normal(size=(n, 3))) * rng.uniform(0.05, 0.6, (n, 1))).astype(np.float32)
    length = np.sqrt(((end - start) ** 2).sum(axis=1, keepdims=True))
    radii = (length * RADII[name]).astype(np.float32)
    lines = fl.Lines.from_segments(np.stack([start, end], axis=1), radius=radii)
    # Aim at both ends, at apexes, at points of the axis and of the surface, and a little beside.
    i = rng.integers(n, size=n_rays)
    place = rng.choice([0, 1, 1, np.nan], n_rays)
    place = np.where(np.isnan(place), rng.random(n_rays), place)
    slope = radii[i, 1] - radii[i, 0]
    apex = np.divide(-radii[i, 0], slope, out=np.ones(n_rays, np.float32), where=slope != 0)
    place = np.where(rng.random(n_rays) < 0.2, np.clip(apex, 0, 2), place)
    axis = unit((end - start)[i])
    beside = unit(rng.normal(size=(n_rays, 3)))
    target = start[i] + place[:, None] * (end - start)[i]
    target = target + beside * rng.choice([0, 0, 1e-7, 1e-6, 1e-5, 1e-4], (n_rays, 1))
    target = target + beside * np.where(rng.random(n_rays) < 0.2, radii[i, 0] + place * slope, 0)[:, None]
    # Come from anywhere, along the axis, nearly so, along the side of the cone, and across the axis.
    across = unit(np.cross(axis, beside))
    sine = np.clip(slope / length[i, 0], -1, 1)[:, None]
    ways = [
        unit(rng.normal(size=(n_rays, 3))),
        axis,
        unit(axis + rng.normal(size=(n_rays, 3)) * rng.choice([1e-6, 1e-4, 1e-2], (n_rays, 1))),
        axis * np.sqrt(1 - sine**2) + across * sine,
        across,
    ]
    directions = np.choose(rng.integers(len(ways), size=(n_rays, 1)), ways) * rng.choice([-1, 1], (n_rays, 1))
    origins = (target - directions * 3).astype(np.float32)
    assert check(lines, origins, directions.astype(np.float32)) > n_rays / 3


@pytest.mark.parametrize("way", [(1.2, 0.6, 0.6), (1, 0, 0), (0.8, 0.6, 0.5), (0.2, 0.5, 0.1)])
@pytest.mark.parametrize("tip", [(0.8, 0.6, 0.5), (0.8, 0.3, 0.1), (0.8, 0.1, 0.2)])
def test_a_ray_through_the_tip_enters_or_leaves_there(
    tip: tuple[float, float, float], way: tuple[float, float, float]
) -> None:
    tree = fl.build(fl.Lines.from_segments([[[0, 0, 0], tip]], radius=[[0.8, 0]]))
    beside = np.array([[0, 0, miss] for miss in (0, 1e-7, 1e-6)])
    hits = tree.first_hit(np.add(tip, way) + beside, np.negative(way), at="surface")
    assert hits.t == pytest.approx(1, abs=1e-4)
    assert hits.points() == pytest.approx(np.broadcast_to(tip, (3, 3)), abs=1e-4)
    back = tree.first_hit(np.subtract(tip, way) + beside, way, at="surface")
    assert back.t_out == pytest.approx(1, abs=1e-4)
