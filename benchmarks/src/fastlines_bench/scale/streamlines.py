"""Generated streamlines in chunks: each chunk is made alone, so none of the scene need be in memory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fastlines import Lines

from ..harness.arrays import Float64Array, FloatArray

#: The segments of a streamline, the bundles of a scene, and the radii of the ellipsoid that they fill.
SEGMENTS, BUNDLES, RADII = 50, 60, (65.0, 88.0, 76.0)

#: The segments of a chunk.
CHUNK = 1_000_000


def chunk(number: int, n_segments: int, seed: int = 0) -> Lines:
    """Return the streamlines of one chunk: parts of cubic curves, in bundles which all chunks share."""
    rng = np.random.default_rng([seed, 31, number])
    n = -(-n_segments // SEGMENTS)
    control = _bundles(seed)[rng.integers(BUNDLES, size=n)] + rng.normal(scale=4, size=(n, 4, 3))
    first, last = rng.uniform(0, 0.4, size=(n, 1)), rng.uniform(0.6, 1, size=(n, 1))
    t = first + (last - first) * np.linspace(0, 1, SEGMENTS + 1)
    weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], axis=2)
    counts = np.full(n, SEGMENTS + 1)
    counts[-1] -= n * SEGMENTS - n_segments
    points = (weights @ control).astype(np.float32).reshape(-1, 3)[: counts.sum()]
    return Lines.from_points(points, counts)


def chunks(n_segments: int, seed: int = 0, size: int = CHUNK) -> Iterator[Lines]:
    """Yield the chunks of a scene."""
    for number, begin in enumerate(range(0, n_segments, size)):
        yield chunk(number, min(size, n_segments - begin), seed)


def whole(n_segments: int, seed: int = 0, size: int = CHUNK) -> Lines:
    """Return the same streamlines in memory."""
    counts, points = [], []
    for part in chunks(n_segments, seed, size):
        sizes = part.strand_sizes()
        last = np.cumsum(sizes) - 1
        ends = np.insert(part.segments[:, 0], last + 1, part.segments[last, 1], axis=0)
        counts.append(sizes + 1)
        points.append(ends)
    return Lines.from_points(np.concatenate(points), np.concatenate(counts))


def rays(n_rays: int, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Return incoherent rays through the ellipsoid, from outside: origins and unit directions."""
    rng = np.random.default_rng([seed, 32])
    directions = rng.normal(size=(n_rays, 3)).astype(np.float32)
    directions /= np.sqrt((directions**2).sum(axis=1, keepdims=True))
    targets = (rng.uniform(-0.5, 0.5, size=(n_rays, 3)) * RADII).astype(np.float32)
    return targets - np.float32(300) * directions, directions


def picture(side: int) -> tuple[FloatArray, FloatArray]:
    """Return coherent rays: those of a square picture of the ellipsoid, seen along z from outside."""
    x, y = np.meshgrid(*[np.linspace(-1, 1, side, dtype=np.float32)] * 2)
    targets = np.stack([RADII[0] * x, RADII[1] * y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    origins = np.broadcast_to(np.array([0, 0, -400], np.float32), targets.shape).copy()
    return origins, targets - origins


def _bundles(seed: int) -> Float64Array:
    rng = np.random.default_rng([seed, 30])
    bundles = rng.normal(size=(BUNDLES, 4, 3))
    bundles *= np.array(RADII) / np.sqrt((bundles**2).sum(axis=2, keepdims=True))
    bundles[:, 1:3] *= 0.5
    return np.asarray(bundles)
