"""Places for letters and numbers where they hide little."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry.hit_places import Float64Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The places of a letter on each side of a rectangle, or on a line, as fractions of its length.
ON_SIDE = (0.12, 0.3, 0.5, 0.7, 0.88)


def apart(choices: Sequence[Float64Array], taken: Float64Array) -> list[Float64Array]:
    """Choose one of several places for each thing, far from what is there and from the places chosen before.

    Parameters
    ----------
    choices : sequence of (k, 2) float64
        The places of each thing; of those that are equally far, the first is chosen.
    taken : (n, 2) float64
        What is there already.

    Examples
    --------
    >>> taken = np.array([[0.0, 0.0]])
    >>> apart([np.array([[0.0, 1.0], [0.0, 2.0]]), np.array([[0.0, 2.5], [0.0, 1.0]])], taken)
    [array([0., 2.]), array([0., 1.])]
    """
    found = list[Float64Array]()
    for places in choices:
        others = np.concatenate([taken, np.reshape(found, (-1, 2))])
        far = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1, initial=np.inf)
        found.append(places[int(far.argmax())])
    return found


def on_line(start: Float64Array, end: Float64Array) -> Float64Array:
    """Return places on a line, (5, 2)."""
    return start + np.array(ON_SIDE)[:, None] * (end - start)


def on_sides(corners: Float64Array) -> Float64Array:
    """Return places on the sides of a rectangle with these corners, (20, 2), the upper side first."""
    return np.concatenate([on_line(corners[i], corners[j]) for i, j in ((3, 2), (0, 3), (1, 2), (0, 1))])


def inside(corners: Float64Array) -> Float64Array:
    """Return places in a rectangle, (9, 2), the middle first."""
    low, high = corners[0], corners[2]
    parts = [(0.5, 0.5), *((x, y) for y in (0.8, 0.5, 0.2) for x in (0.2, 0.5, 0.8) if (x, y) != (0.5, 0.5))]
    return np.asarray(low + np.array(parts) * (high - low))


def along_strokes(strokes: Float64Array, most: int = 4000) -> Float64Array:
    """Return points along strokes (n, k, 2) from their first to their second point, (m, 2)."""
    some = strokes[:: max(1, -(-len(strokes) * 5 // most))]
    return np.concatenate([some[:, 0] + s * (some[:, 1] - some[:, 0]) for s in np.linspace(0, 1, 5)])


def write(axes: Axes, text: str, at: Float64Array, color: Any) -> None:
    """Write a letter or a number, centred, on a little paper."""
    paper = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    more: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "small", "fontweight": "bold", "bbox": paper}
    axes.text(float(at[0]), float(at[1]), text, color=color, zorder=5, **more)
