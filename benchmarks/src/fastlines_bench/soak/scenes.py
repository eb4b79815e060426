"""Random scenes that break a careless tree, layout or exact test: a shape of axes, and what is done to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[Any]
Random: TypeAlias = np.random.Generator

#: A function that makes n axes, (n, 2, 3) float64, of about unit size.
Axes: TypeAlias = Callable[[Random, int], Array]


def scattered(rng: Random, n: int) -> Array:
    """Return short lines of any direction."""
    start = rng.uniform(-1, 1, (n, 3))
    return np.stack([start, start + rng.normal(0, 0.2, (n, 3))], axis=1)


def crossing(rng: Random, n: int) -> Array:
    """Return long lines from side to side."""
    ends = rng.uniform(-1, 1, (n, 2, 3))
    axis = rng.integers(0, 3, n)
    ends[np.arange(n), 0, axis], ends[np.arange(n), 1, axis] = -1, 1
    return ends


def hair(rng: Random, n: int) -> Array:
    """Return strands of eight steps, whose segments share their ends."""
    steps = np.array([0, 0, 0.1]) + rng.normal(0, 0.03, (-(-n // 8), 9, 3))
    points = rng.uniform(-1, 1, (len(steps), 1, 3)) * [1, 1, 0] + np.cumsum(steps, axis=1)
    return np.asarray(np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)[:n])


def star(rng: Random, n: int) -> Array:
    """Return lines through one point, half of which end there; at zero, boxes around it shrink to nothing."""
    ends = np.stack([np.zeros((n, 3)), rng.normal(0, 0.5, (n, 3))], axis=1)
    ends[::2, 0] = -ends[::2, 1]
    return np.asarray(ends + rng.choice([0.0, 0.25]) * np.array([1, 2, -0.5]))


def equal_boxes(rng: Random, n: int) -> Array:
    """Return the diagonals of one box, either way round."""
    sign = rng.choice([-1.0, 1.0], (n, 3))
    return np.asarray(np.stack([sign, -sign], axis=1) * [1, 0.7, 0.4])


def axis_parallel(rng: Random, n: int) -> Array:
    """Return lines of a lattice: equal coordinates, flat boxes, shared planes."""
    start, step = rng.integers(-4, 5, (n, 3)) / 4, np.zeros((n, 3))
    step[np.arange(n), rng.integers(0, 3, n)] = rng.integers(-4, 5, n) / 4
    return np.stack([start, start + step], axis=1)


def collinear(rng: Random, n: int) -> Array:
    """Return lines on one line, which overlap."""
    direction = rng.choice([0.0, 1.0, -0.5], 3)
    along = rng.uniform(-1, 1, (n, 2, 1))
    return np.asarray(along * (direction if direction.any() else np.array([1.0, 0, 0])))


def thin(rng: Random, n: int) -> Array:
    """Return lines in a plane, but for heights of 1e-30 to 1e-3."""
    heights = rng.choice([0.0, 1e-30, 1e-18, 1e-9, 1e-6, 1e-3], (n, 2)) * rng.choice([-1, 1], (n, 2))
    ends = crossing(rng, n)
    ends[..., 2] = heights
    return ends


def tiny(rng: Random, n: int) -> Array:
    """Return lines of a few units in the last place, or of length zero."""
    start = rng.uniform(-1, 1, (n, 3))
    return np.stack([start, start + rng.integers(-3, 4, (n, 3)) * 2.0**-24], axis=1)


def outlier(rng: Random, n: int) -> Array:
    """Return a small bundle, and one line that makes the scene a thousand times larger."""
    ends = scattered(rng, n)
    ends[:1] *= 1000
    return ends


SHAPES: dict[str, Axes] = {
    "scattered": scattered,
    "crossing": crossing,
    "hair": hair,
    "star": star,
    "equal boxes": equal_boxes,
    "axis parallel": axis_parallel,
    "collinear": collinear,
    "thin": thin,
    "tiny": tiny,
    "outlier": outlier,
}


def with_duplicates(rng: Random, ends: Array) -> Array:
    """Replace most lines by copies of a few, some of them turned round."""
    ends = ends[rng.integers(0, max(1, len(ends) // 6), len(ends))]
    turned = rng.random(len(ends)) < 0.3
    ends[turned] = ends[turned, ::-1]
    return ends


def with_points(rng: Random, ends: Array) -> Array:
    """Make some lines points."""
    ends = ends.copy()
    chosen = rng.random(len(ends)) < 0.3
    ends[chosen, 1] = ends[chosen, 0]
    return ends


def on_grid(rng: Random, ends: Array) -> Array:
    """Round all coordinates, so that many are equal."""
    return np.asarray(np.round(ends * 8) / 8)


def flattened(rng: Random, ends: Array) -> Array:
    """Project all lines on a plane."""
    return np.asarray(ends * (np.arange(3) != rng.integers(3)))


#: What may be done to a scene, and how often.
CHANGES: dict[str, tuple[float, Callable[[Random, Array], Array]]] = {
    "duplicates": (0.15, with_duplicates),
    "points": (0.15, with_points),
    "grid": (0.1, on_grid),
    "flat": (0.08, flattened),
}


def random_axes(rng: Random, n: int, shape: str | None = None) -> tuple[str, Array]:
    """Return the name of a random shape and its axes, (n, 2, 3) float32: changed, scaled by 1e-8 to 1e8, far away."""
    name = shape or str(rng.choice(list(SHAPES)))
    ends = SHAPES[name](rng, n)
    for chance, change in CHANGES.values():
        if rng.random() < chance:
            ends = change(rng, ends)
    if rng.random() < 0.3:
        ends = ends + rng.choice([-1.0, 1.0, 0.3], 3) * 10 ** rng.uniform(0, 5)
    if rng.random() < 0.3:
        ends = ends * 10 ** rng.uniform(-8, 8)
    return name, ends.astype(np.float32)


def size_of(points: Array) -> float:
    """Return the longest side of the box of points, (…, 3); 1 if it has none."""
    corners = np.asarray(points, np.float64).reshape(-1, 3)
    return float(np.ptp(corners, axis=0).max(initial=0)) or 1.0 if len(corners) else 1.0


def random_radii(rng: Random, ends: Array) -> Array:
    """Return a radius for each end, (n, 2) float32: none to larger than the lines; some let one ball hold the other."""
    radii = rng.random((len(ends), 2)) ** 8 * 0.3 * size_of(ends)
    for chance, change in ((0.15, lambda r: 0 * r), (0.15, lambda r: np.repeat(r[:, :1], 2, axis=1))):
        chosen = rng.random(len(ends)) < chance
        radii[chosen] = change(radii[chosen])
    if rng.random() < 0.2:
        radii[:, 1] = 0  # all taper to a tip
    return radii.astype(np.float32)
