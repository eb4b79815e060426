"""Spheres and meshes of any size, made by seeded generators within about the unit cube."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from fastlines import scenes

from ...harness.arrays import Float64Array, FloatArray, IntArray


@dataclass(frozen=True)
class Solid:
    """Spheres, as (n, 4) x, y, z and radius, or a mesh: (m, 3) vertices, and the (n, 3) corners of triangles."""

    vertices: FloatArray
    index: IntArray | None = None

    def __len__(self) -> int:
        return len(self.vertices if self.index is None else self.index)


def balls(n: int, seed: int = 0) -> Solid:
    """Return spheres around uniform points of the cube; their radii vary by a factor of ten."""
    rng = np.random.default_rng([seed, 11])
    least = 0.001 * (1e5 / max(1, n)) ** (1 / 3)
    radius = least * 10 ** rng.random(n)
    return Solid(np.concatenate([rng.random((n, 3)), radius[:, None]], axis=1).astype(np.float32))


def beads(n: int, seed: int = 0) -> Solid:
    """Return spheres strung along the segments of spaghetti, at 50 places of each; they touch at most."""
    n_lines = -(-n // 50)
    rng = np.random.default_rng([seed, 12])
    ends = scenes.make("spaghetti", max(1, n_lines), seed).lines.segments.astype(np.float64)
    place = ((np.arange(50) + 0.5) / 50)[:, None]
    centres = (ends[:, None, 0] + place * (ends[:, None, 1] - ends[:, None, 0])).reshape(-1, 3)[:n]
    spacing = np.repeat(np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1)) / 50, 50)[:n]
    radius = spacing * rng.uniform(0.1, 0.5, n)
    return Solid(np.concatenate([centres, radius[:, None]], axis=1).astype(np.float32))


def icosphere(n: int, seed: int = 0) -> Solid:
    """Return a bumpy sphere of 20 · 4^k triangles, the nearest to n: a subdivided icosahedron."""
    golden = (1 + 5**0.5) / 2
    corners = np.array([[0, a, b * golden] for a in (-1, 1) for b in (-1, 1)], np.float64)
    points = np.concatenate([np.roll(corners, k, axis=1) for k in range(3)])
    # The faces are the triples of corners that are two apart.
    near = np.isclose(((points[:, None] - points) ** 2).sum(axis=2), 4)
    triangles = np.array([face for face in combinations(range(12), 3) if near[np.ix_(face, face)].sum() == 6])
    for _ in range(max(0, round(np.log(max(n, 1) / 20) / np.log(4)))):
        points, triangles = _subdivide(points, triangles)
    points /= np.sqrt((points**2).sum(axis=1, keepdims=True))
    waves = np.random.default_rng([seed, 13]).normal(size=(12, 3)) * np.geomspace(3, 40, 12)[:, None]
    height = (np.sin(points @ waves.T) / np.geomspace(3, 40, 12)).sum(axis=1)
    return Solid((0.5 + 0.42 * points * (1 + 0.25 * height[:, None])).astype(np.float32), triangles)


def _subdivide(points: Float64Array, triangles: IntArray) -> tuple[Float64Array, IntArray]:
    """Cut each triangle into four at the middles of its edges."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges, which = np.unique(edges, axis=0, return_inverse=True)
    middle = len(points) + which.reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = triangles.T, middle.T
    parts = [np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate([points, points[edges].mean(axis=1)]), np.stack(parts, axis=1).reshape(-1, 3)


def knot(n: int, seed: int = 0) -> Solid:
    """Return a tube along a torus knot, of about n triangles."""
    across = max(3, round((n / 16) ** 0.5))
    along = max(8, 8 * across)
    s = 2 * np.pi * np.arange(along) / along
    centre = np.stack([(2 + np.cos(3 * s)) * np.cos(2 * s), (2 + np.cos(3 * s)) * np.sin(2 * s), np.sin(3 * s)], axis=1)
    forward = np.roll(centre, -1, axis=0) - np.roll(centre, 1, axis=0)
    side = np.cross(forward, centre)
    up = np.cross(side, forward)
    side, up = (v / np.sqrt((v**2).sum(axis=1, keepdims=True)) for v in (side, up))
    turn = 2 * np.pi * np.arange(across) / across
    radius = 0.45 * (1 + 0.1 * np.random.default_rng([seed, 14]).normal(size=(along, across, 1)) / across)
    ring = np.cos(turn)[None, :, None] * side[:, None] + np.sin(turn)[None, :, None] * up[:, None]
    points = 0.5 + (centre[:, None] + radius * ring) / 7
    return Solid(points.reshape(-1, 3).astype(np.float32), _grid(along, across, wrap=True))


def terrain(n: int, seed: int = 0) -> Solid:
    """Return a height field of about n triangles: sines of ever shorter waves."""
    size = max(1, round((n / 2) ** 0.5))
    rng = np.random.default_rng([seed, 15])
    x, z = np.meshgrid(*[np.linspace(0, 1, size + 1)] * 2, indexing="ij")
    height = np.full_like(x, 0.5)
    for length in np.geomspace(3, 300, 24):
        direction, phase = rng.normal(size=2), rng.uniform(0, 2 * np.pi)
        height += 0.25 / length * np.sin(length * (direction[0] * x + direction[1] * z) + phase)
    points = np.stack([x, height, z], axis=2).reshape(-1, 3)
    return Solid(points.astype(np.float32), _grid(size, size, wrap=False))


def _grid(rows: int, columns: int, wrap: bool) -> IntArray:
    """Return two triangles for each cell of a grid of points, with an edge more of these unless it wraps around."""
    n_rows, n_columns = rows + (not wrap), columns + (not wrap)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    down, right = (i + 1) % n_rows, (j + 1) % n_columns
    a, b, c, d = (u * n_columns + v for u, v in ((i, j), (down, j), (i, right), (down, right)))
    return np.stack([a, b, c, c, b, d], axis=1).reshape(-1, 3)


#: The generators of spheres and of meshes by name, each with its number of primitives by default.
SPHERES: dict[str, tuple[Callable[[int, int], Solid], int]] = {"balls": (balls, 100_000), "beads": (beads, 100_000)}
MESHES: dict[str, tuple[Callable[[int, int], Solid], int]] = {
    "icosphere": (icosphere, 327_680),
    "knot": (knot, 262_144),
    "terrain": (terrain, 1_000_000),
}
