"""Cubic curves of every kind, and how far their pieces are from them, sampled in float64."""

from __future__ import annotations

import numpy as np

import fastlines as fl

#: Places on a piece at which it is compared with its curve.
PARTS = np.linspace(0, 1, 33)


def bernstein(coefficients: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return the points (n, len(t), …) of Bezier curves (n, 4, …), from the definition."""
    weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], axis=1)
    return np.einsum("tk,nk...->nt...", weights, coefficients.astype(np.float64))


def random_curves(n: int = 40, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(size=(n, 4, 3)), axis=1), rng.uniform(0, 0.3, (n, 4))


QUARTER = np.array([[1, 0, 0], [1, 0.552285, 0], [0.552285, 1, 0], [0, 1, 0]])
STRAIGHT = np.linspace([0.1, 0.2, 0.3], [1.3, 0.7, -2.1], 4)
LOOP = np.array([[0, 0, 0], [3, 2, 0], [-2, 2, 0], [1, 0, 0]])
CUSP = np.array([[0, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0]])
#: Control points and radii.
SHAPES = {
    "random": random_curves(),
    "tapered to a point": (random_curves(seed=1)[0], [[0.2, 0.0]] * 40),
    "thin": (random_curves(seed=2)[0], 1e-4),
    "thicker than long": (random_curves(seed=3)[0] * 1e-3, random_curves(seed=3)[1]),
    "a radius of nothing": (random_curves(seed=4)[0], 0.0),
    "no radius": (random_curves(seed=5)[0], None),
    "a quarter": (QUARTER[None], 0.01),
    "straight": (STRAIGHT[None], 0.01),
    "straight, uneven": (STRAIGHT[None, [0, 0, 1, 3]], 0.01),
    "straight, tapered": (STRAIGHT[None], [[0.3, 0.01]]),
    "straight, with a belly": (STRAIGHT[None], [[0.0, 0.4, 0.1, 0.0]]),
    "loop": (LOOP[None], 0.1),
    "cusp": (CUSP[None], [[0.1, 0.2]]),
    "there and back": (STRAIGHT[None, [0, 3, 3, 0]], 0.1),
    "standing at its ends": (QUARTER[None, [0, 0, 3, 3]], 0.1),
    "a point": (np.ones((1, 4, 3)), [[0.1, 0.9, 0.7, 0.2]]),
    "far from zero": (random_curves(seed=6)[0] + 1000, 0.05),
    "radii below zero": (random_curves(seed=7)[0], "overshoot"),
}


def curves_of(shape: str, scale: float = 1.0, tolerance: float | None = None) -> fl.Curves:
    control, radius = SHAPES[shape]
    control = np.asarray(control * scale, np.float32)
    if isinstance(radius, str):
        radii = np.tile(np.array([0.01, -0.2, 0.1, 0.2]) * scale, (len(control), 1)).astype(np.float32)
        return fl.Curves(control, radii, tolerance=tolerance)
    return fl.Curves.from_bezier(control, None if radius is None else np.multiply(radius, scale), tolerance=tolerance)


def errors(curves: fl.Curves) -> tuple[np.ndarray, np.ndarray]:
    """Return how far each piece is from its curve where it is sampled, (n_pieces,), and the least radius there.

    The sum of the distance of two centres and the difference of two radii is the Hausdorff distance of two balls.
    """
    pieces, s = curves.pieces, PARTS
    begin, end = pieces.begin.astype(np.float64)[:, None], pieces.end.astype(np.float64)[:, None]
    u = begin + s * (end - begin)
    weights = np.stack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3], axis=2)
    points = np.einsum("ptk,pkx->ptx", weights, curves.control[pieces.curve].astype(np.float64))
    ends = pieces.lines.segments.astype(np.float64)
    chord = ends[:, None, 0] + s[:, None] * (ends[:, None, 1] - ends[:, None, 0])
    radius = chord_radius = np.zeros(u.shape)
    if curves.radius is not None:
        radius = np.maximum(np.einsum("ptk,pk->pt", weights, curves.radius[pieces.curve].astype(np.float64)), 0)
        r = pieces.lines.radius.astype(np.float64)
        chord_radius = r[:, :1] + s * (r[:, 1:] - r[:, :1])
    is_point = (curves.control == curves.control[:, :1]).all(axis=(1, 2))[pieces.curve]
    # The largest ball around a point holds the others.
    gap = np.where(is_point[:, None], np.maximum(radius - chord_radius, 0), np.abs(radius - chord_radius))
    return (np.linalg.norm(points - chord, axis=2) + gap).max(axis=1), radius.min(axis=1)


def float32_rounding(curves: fl.Curves) -> float:
    """Return what the rounding of ends of pieces, and their radii, to float32 may add."""
    return 2.0**-23 * (float(np.abs(curves.control).max()) + curves.max_radius)
