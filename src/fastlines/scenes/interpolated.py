"""Dense hair from a few guides: new strands between those that artists or simulations make.

Each new strand is a mean of three guides that start near each other and run alike, with random weights. Its root moves
a little, and all its points with it. Sources: the hair of Sintel and of games is made so, for instance Yuksel and
Tariq, "Advanced Techniques in Real-time Hair Rendering and Simulation", SIGGRAPH 2010, §2.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import count
from ..errors import InputError
from ..geometry.lines import Lines

#: How many guides that start nearest to another one are compared; the two whose ends are nearest are chosen.
NEAR = 6


def dense_hair(guides: npt.ArrayLike, n_strands: int, seed: int = 0) -> Lines:
    """Interpolate strands between guides.

    Parameters
    ----------
    guides : (n_guides, n_points, 3) array
        The points of each guide, from the root to the tip.
    n_strands : int
        How many strands are made. All are new; none is a guide.
    seed : int
        Of the random numbers.

    Returns
    -------
    Lines
        Of n_points - 1 segments a strand.

    Raises
    ------
    InputError
        If the guides have another shape, or are fewer than three.

    Examples
    --------
    >>> guides = np.zeros((10, 16, 3))
    >>> guides[..., 0], guides[..., 1] = np.arange(10)[:, None], np.linspace(0, 1, 16)
    >>> dense_hair(guides, 1000)
    <Lines: 15,000 segments, 1,000 strands>
    """
    points = np.asarray(guides, np.float32)
    if points.ndim != 3 or points.shape[0] < 3 or points.shape[1] < 2 or points.shape[2] != 3:
        raise InputError(f"guides have shape {points.shape}; expected (3 or more, 2 or more, 3)")
    count("n_strands", n_strands, 1)
    rng = np.random.default_rng(seed)
    neighbours, spacing = _neighbours(points)

    # Choose a guide and its neighbours, and weights that are uniform over the triangle.
    chosen = rng.integers(len(points), size=n_strands)
    weights = rng.dirichlet((1.0, 1.0, 1.0), size=n_strands).astype(np.float32)
    made = weights[:, 0, None, None] * points[chosen]
    for i in (0, 1):
        made += weights[:, i + 1, None, None] * points[neighbours[chosen, i]]
    made += rng.normal(scale=0.3, size=(n_strands, 1, 3)).astype(np.float32) * spacing[chosen, None, None]
    return Lines.from_points(made.reshape(-1, 3), np.full(n_strands, points.shape[1]))


def _neighbours(points: npt.NDArray[np.float32]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32]]:
    """Return two guides for each that start near it and end near it, and the distance to the nearest root."""
    roots, tips = points[:, 0], points[:, -1]
    near = min(NEAR, len(points) - 1)
    found, spacing = np.empty((len(points), 2), np.int64), np.empty(len(points), np.float32)
    for start in range(0, len(points), 1024):
        rows = np.arange(start, min(start + 1024, len(points)))
        away = ((roots[rows, None] - roots) ** 2).sum(axis=2)
        away[np.arange(len(rows)), rows] = np.inf
        close = np.argpartition(away, near - 1, axis=1)[:, :near]
        apart = ((tips[close] - tips[rows, None]) ** 2).sum(axis=2)
        found[rows] = np.take_along_axis(close, np.argsort(apart, axis=1)[:, :2], axis=1)
        spacing[rows] = np.sqrt(away.min(axis=1))
    return found, spacing
