"""How large the demonstration is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..methods import THESIS_METHODS
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
    rays : int
        Timed are rays² camera rays for each query.
    budget : float
        Seconds for one timing; where it would take longer, only 1/4, 1/16, … of the rays are asked, evenly spread.
    picture : int
        Width and height of a depth picture in pixels.
    samples : int
        Take the mean of so many by so many samples in each of its pixels.
    panel : int
        Width and height of a level's panel in pixels.
    levels : int
        How many levels of a tree are drawn.
    drawn : tuple of str
        The trees whose levels are drawn.
    """

    name: str
    scenes: Mapping[str, int | None] = field(default_factory=lambda: dict.fromkeys(NAMES))
    methods: tuple[str, ...] = THESIS_METHODS
    rays: int = 512
    budget: float = 2.0
    picture: int = 600
    samples: int = 2
    panel: int = 320
    levels: int = 6
    drawn: tuple[str, ...] = ("bvh-d2", "kd-d2")


#: Everything as large as in the thesis: some minutes.
FULL = Plan("full")

#: About half a minute on two cores.
QUICK = Plan(
    "quick",
    scenes={
        "bun-hair": 6_000,
        "straight-hair": 8_000,
        "spaghetti": 2_000,
        "spaghetti-2": 2_500,
        "photon-beams": 2_500,
    },
    rays=128,
    budget=0.1,
    picture=224,
    panel=224,
)
