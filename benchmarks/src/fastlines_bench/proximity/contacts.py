"""Lines that touch: knitted yarn, a pile of rods, and long lines that cross; seeded, of any number of segments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fastlines import Lines, scenes

#: The segments of a loop of yarn.
PER_LOOP = 24

#: The distance of two axes of yarn that touch: the least distance of neighbouring rows is 1.5.
YARN = 1.6

#: The distance of two axes of rods that touch, and the rods in a cube whose side is the length of a rod.
ROD, DENSITY = 0.04, 100

#: The radius of long lines across the unit cube.
CROSSING = 0.005


@dataclass(frozen=True, eq=False)
class ContactScene:
    """Lines some of which touch.

    Attributes
    ----------
    name : str
        One of `GENERATORS`.
    lines : Lines
    radius : float
        The largest distance of two segments that touch.
    skip_neighbours : int
        Segments of a strand that are at most this many apart are no pair.
    """

    name: str
    lines: Lines
    radius: float
    skip_neighbours: int = 0


def yarn(n_segments: int) -> ContactScene:
    """Return rows of knitted loops, about as long as the fabric is high; a row is a strand.

    A row is the curve (t + 1.5 sin 2t, 4 cos t, cos 2t), and the next row lies 5 above. Source: Crane, "A simple
    parametric model of plain-knit yarns", 2023.
    """
    n_loops = max(1, round((n_segments / PER_LOOP * 5 / (2 * np.pi)) ** 0.5))
    per_row = n_loops * PER_LOOP
    counts = np.full(-(-n_segments // per_row), per_row + 1)
    counts[-1] = n_segments - (len(counts) - 1) * per_row + 1
    row = np.repeat(np.arange(len(counts)), counts)
    t = 2 * np.pi / PER_LOOP * (np.arange(len(row)) - (np.cumsum(counts) - counts)[row])
    points = np.stack([t + 1.5 * np.sin(2 * t), 4 * np.cos(t) + 5 * row, np.cos(2 * t)], axis=1)
    return ContactScene("yarn", Lines.from_points(points.astype(np.float32), counts), YARN, 3)


def rods(n_segments: int, seed: int = 0) -> ContactScene:
    """Return rods of length 1 at random in a cube that grows with their number."""
    rng = np.random.default_rng([seed, 31])
    centres = rng.random((n_segments, 3)) * (n_segments / DENSITY) ** (1 / 3)
    half = rng.normal(size=(n_segments, 3))
    half /= 2 * np.sqrt((half**2).sum(axis=1, keepdims=True))
    ends = np.stack([centres - half, centres + half], axis=1)
    return ContactScene("rods", Lines.from_segments(ends.astype(np.float32)), ROD)


def crossing(n_segments: int) -> ContactScene:
    """Return long lines through the unit cube: the scene spaghetti."""
    return ContactScene("crossing", scenes.make("spaghetti", n_segments).lines, CROSSING)


GENERATORS: dict[str, Callable[[int], ContactScene]] = {"yarn": yarn, "rods": rods, "crossing": crossing}
