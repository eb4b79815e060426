"""Spaghetti: long segments right across a cube (thesis §6), the hardest case for trees of whole primitives.

Each segment joins two uniform random points on two opposite faces of the unit cube, a random pair for each segment.
All boxes overlap in the middle of the cube.
"""

from __future__ import annotations

import numpy as np

from ..geometry.lines import Lines


def generate(n_segments: int, rng: np.random.Generator) -> Lines:
    """Draw segments, each a strand, from the face at 0 to the face at 1 of its axis, from five uniform numbers each.

    Examples
    --------
    >>> lines = generate(3, np.random.default_rng(0))
    >>> (lines.segments[:, 1] - lines.segments[:, 0]).max(axis=1).tolist()
    [1.0, 1.0, 1.0]
    """
    uniform = rng.random((n_segments, 5))
    axis = (3 * uniform[:, 0]).astype(np.int64)
    segments = np.empty((n_segments, 2, 3))
    rows = np.arange(n_segments)
    for end in (0, 1):
        segments[rows, end, axis] = end
        segments[rows, end, (axis + 1) % 3] = uniform[:, 1 + 2 * end]
        segments[rows, end, (axis + 2) % 3] = uniform[:, 2 + 2 * end]
    return Lines.from_segments(segments, strands=rows)
