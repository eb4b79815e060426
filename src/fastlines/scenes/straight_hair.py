"""Straight hair: long hair, parted in the middle, that falls over the head and straight down (thesis §6).

The strands leave the skin away from the parting (behind it, away from its end at the crown) and slide down over the
head in layers. They come together at the neck and hang to about the same level, as if cut. Neighbouring strands form
locks: each is drawn to one strand of its lock, most strongly at its tip.
"""

from __future__ import annotations

import numpy as np

from ..camera import Float64Array
from ..geometry.lines import Lines
from .hair import CROWN, Head, resample, to_lines, unit

N_PER_STRAND = 20
N_LOCKS = 240
HEAD = Head(centre=(0.5, 0.71, 0.52), radii=(0.2, 0.25, 0.24))


def generate(n_segments: int, rng: np.random.Generator) -> Lines:
    """Grow strands of 20 segments, from eight uniform numbers for each lock, then for each strand.

    Examples
    --------
    >>> lines = generate(50, np.random.default_rng(0))
    >>> len(lines), lines.n_strands
    (50, 3)
    """
    n_strands = -(-n_segments // N_PER_STRAND)
    lock_roots, locks = _grow(rng.random((N_LOCKS, 8)))
    uniform = rng.random((n_strands, 8))
    roots, strands = _grow(uniform)

    # Join the lock whose root is the nearest on the same side of the parting.
    distance = np.where(roots[:, :1] * lock_roots[:, 0] > 0, 0.0, 9.0)
    for axis in range(3):
        distance += (roots[:, axis, None] - lock_roots[:, axis]) ** 2
    lock = locks[distance.argmin(axis=1)]
    share = (0.85 * uniform[:, 7, None] * np.linspace(0, 1, N_PER_STRAND + 1))[..., None]
    strands += share * (lock - strands)
    return to_lines(HEAD.push_out(strands, 0.002), n_segments)


def _grow(uniform: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Make roots (s, 3) and strands (s, 21, 3) of random numbers (s, 8)."""
    roots = HEAD.roots(uniform[:, :2])
    spread = 2 * uniform[:, 2:5] - 1
    height = 0.004 + 0.032 * uniform[:, 5]

    # Comb away from the nearest point of the parting and down, along the skin.
    comb = roots * (1, 0, 1)
    comb[:, 2] = np.minimum(0, comb[:, 2] - CROWN[2])
    comb = unit(comb) + (0, -0.7, 0) + 0.2 * spread
    comb -= (comb * roots).sum(axis=1, keepdims=True) * roots
    pull = np.array([0.0, -10.0, 0.0]) + np.array([0.6, 0.0, 0.6]) * spread
    fine = HEAD.fall(roots, unit(0.3 * roots + unit(comb)), height, pull, length=1.25, n_steps=125)

    # Draw the hair together at the neck.
    narrow = 1 - 0.1 * np.exp(-(((fine[..., 1] - 0.36) / 0.14) ** 2))
    fine = HEAD.centre + (fine - HEAD.centre) * np.stack([narrow, np.ones_like(narrow), narrow], axis=-1)

    # Cut where a strand reaches the level of the ends: the rest of the points repeat the last one.
    level = 0.02 + 0.1 * uniform[:, 6] ** 2
    last = (fine[..., 1] > level[:, None]).sum(axis=1, keepdims=True) - 1
    return roots, resample(fine, N_PER_STRAND, last)
