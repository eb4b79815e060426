"""Bun hair: hair combed to the back of the head, twisted into a rope and wound into a bun (thesis §6).

The strands run over the scalp to the tie, pass through it and continue as one rope. The rope climbs from the tie, and
coils around itself outwards and down to the head. A few stray hairs escape around the hairline.
"""

from __future__ import annotations

import numpy as np

from ..camera import Float64Array
from ..geometry.lines import Lines
from .hair import Head, resample, to_lines, unit

N_PER_STRAND = 50
HEAD = Head(centre=(0.5, 0.48, 0.56), radii=(0.29, 0.38, 0.36))

#: Where the hair is tied, as a direction from the middle of the head.
TIE = np.array([0.0, 0.55, -0.8352])
#: The fraction of strands that escape.
STRAY = 0.04

N_SCALP, N_COIL = 40, 160
#: A small bun, so that 50 segments divide a strand finely: with 2.75 turns around a larger one, segments are twice as
#: long.
TURNS = 1.75


def generate(n_segments: int, rng: np.random.Generator) -> Lines:
    """Grow strands of 50 segments, from sixteen uniform numbers each.

    Examples
    --------
    >>> lines = generate(120, np.random.default_rng(0))
    >>> len(lines), lines.n_strands
    (120, 3)
    """
    n_strands = -(-n_segments // N_PER_STRAND)
    uniform = rng.random((n_strands, 16))
    stray = uniform[:, 2] < STRAY
    uniform[stray, 0] = 1 - 0.3 * uniform[stray, 0]  # near the hairline
    roots = HEAD.roots(uniform[:, :2])
    strands = np.empty((n_strands, N_PER_STRAND + 1, 3))
    strands[~stray] = _wound(roots[~stray], uniform[~stray])
    strands[stray] = _loose(roots[stray], uniform[stray])
    return to_lines(HEAD.push_out(strands, 0.001), n_segments)


def _wound(roots: Float64Array, uniform: Float64Array) -> Float64Array:
    """Run strands through the tie and around the bun."""
    fine = np.concatenate([_over_scalp(roots, uniform), _coil(uniform)], axis=1)
    # Round off the bend at the tie.
    for _ in range(12):
        fine[:, 1:-1] = (fine[:, :-2] + 2 * fine[:, 1:-1] + fine[:, 2:]) / 4
    return resample(HEAD.push_out(fine, 0.002), N_PER_STRAND)


def _over_scalp(roots: Float64Array, uniform: Float64Array) -> Float64Array:
    """Comb from each root to the tie, the shortest way along the head, in layers."""
    # Stop before the tie, where all paths cross.
    t = np.linspace(0, 0.88, N_SCALP)
    ways = unit((1 - t)[:, None] * roots[:, None] + t[:, None] * TIE)
    height = (0.003 + 0.022 * uniform[:, 3, None]) * np.minimum(1, 6 * t)
    wave = 0.02 * (uniform[:, 4, None] - 0.5) * np.sin(np.pi * t)
    return HEAD.at(unit(ways + wave[..., None] * np.cross(ways, TIE)), height)


def _coil(uniform: Float64Array) -> Float64Array:
    """Wind the rope: a spiral around the axis of the bun, with the strands twisted around its middle."""
    axis = unit(TIE / HEAD.radii)
    across = np.array([1.0, 0.0, 0.0])
    along = np.cross(axis, across)
    s = np.linspace(0, 1, N_COIL)
    turn = 2 * np.pi * TURNS * s
    outward = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * along
    radius = 0.02 + 0.03 * s**0.8
    height = 0.02 + 0.1 * np.minimum(1, 8 * s) * (1 - s**1.5)
    middle = HEAD.at(TIE) + radius[:, None] * outward + height[:, None] * axis

    # Place each strand in the rope's cross-section, which turns along the rope.
    twist = 2 * np.pi * (uniform[:, 5, None] + s)
    taper = np.minimum(1, 0.5 + 4 * s) * np.minimum(1, 0.05 + 6 * (1 - s))
    thick = 0.036 * np.sqrt(uniform[:, 6, None]) * taper
    x, y = (thick * np.cos(twist))[..., None], (thick * np.sin(twist))[..., None]
    return np.asarray(middle + x * outward + y * axis)


def _loose(roots: Float64Array, uniform: Float64Array) -> Float64Array:
    """Grow short strands that stand off and fall."""
    spread = 2 * uniform[:, 7:10] - 1
    pull = np.array([0.0, -14.0, 0.0]) + 6 * (2 * uniform[:, 10:13] - 1)
    height = 0.01 + 0.02 * uniform[:, 13]
    fine = HEAD.fall(roots, unit(0.5 * roots + TIE + 0.5 * spread), height, pull, length=0.2, n_steps=60)
    last = (60 * (0.3 + 0.7 * uniform[:, 14, None])).astype(np.int64)
    return resample(fine, N_PER_STRAND, last)
