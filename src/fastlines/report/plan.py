"""How large the report is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..bench.tuning import LENGTHS
from ..demo import QUICK as QUICK_DEMO
from ..methods import DEFAULT_METHOD, THESIS_METHODS
from ..scenes import NAMES


@dataclass(frozen=True)
class Plan:
    """What to build, ask and draw.

    Parameters
    ----------
    name : str
        What the page calls it.
    scenes : mapping of str to int or None
        The scenes and how many segments each has; None = as many as in the thesis.
    methods : tuple of str
        The trees.
    peer : bool
        Measure Embree too, if it is installed.
    size : int
        Times are for the size² rays of a square picture.
    budget : float
        Seconds for the rays of one figure; where all would take longer, as many are asked as there is time for.
    build_limit : float
        Seconds; a build that takes longer is ended.
    lengths : tuple of float
        To what shares of the box's diagonal segments are cut for Embree.
    picture, samples : int
        Width and height of a depth picture in pixels, and of the grid of samples in each.
    heat : int
        Width and height of the pictures of visits.
    panel, levels : int
        Width and height of a level's panel, and how many levels of a tree are drawn.
    drawn : tuple of str
        The trees whose levels are drawn.
    depths : tuple of int
        The rows of the table of thesis §4.3.
    """

    name: str
    scenes: Mapping[str, int | None] = field(default_factory=lambda: dict.fromkeys(NAMES))
    methods: tuple[str, ...] = (*THESIS_METHODS, DEFAULT_METHOD)
    peer: bool = True
    size: int = 512
    budget: float = 1.0
    build_limit: float = 120.0
    lengths: tuple[float, ...] = (*LENGTHS, 1 / 256)
    picture: int = 400
    samples: int = 3
    heat: int = 256
    panel: int = 200
    levels: int = 6
    drawn: tuple[str, ...] = ("bvh-cl", "bvh-d2", "kd-d2")
    depths: tuple[int, ...] = (0, 1, 2, 3)


#: Everything as large as in the thesis.
FULL = Plan("full")

#: Small scenes and few rays. Bun Hair has half of its segments: KD trees cost much less than BVHs only on dense hair.
QUICK = Plan(
    "quick",
    scenes={**QUICK_DEMO.scenes, "bun-hair": 40_000},
    size=256,
    budget=0.06,
    build_limit=20.0,
    picture=240,
    samples=2,
    heat=128,
    panel=160,
)
