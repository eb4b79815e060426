"""The size of the repeated chapter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fastlines.scenes import NAMES

from ..harness.internals import DEFAULT_METHOD, THESIS_METHODS
from ..harness.preset import Preset, sized
from ..peers.tuning import LENGTHS

#: Bun Hair keeps half of its segments, because KD trees cost much less than BVHs only on dense hair.
QUICK_SCENES = {
    "bun-hair": 40_000,
    "straight-hair": 8_000,
    "spaghetti": 2_000,
    "spaghetti-2": 2_500,
    "photon-beams": 2_500,
}


@dataclass(frozen=True, kw_only=True)
class ThesisPreset(Preset):
    """What to build, time and draw.

    Parameters
    ----------
    name : str
        The name of the preset on the page.
    scenes : mapping of str to int or None
        The scenes and their numbers of segments; None = as in the thesis.
    methods : tuple of str
        The methods of the trees.
    peer : bool
        Measure Embree too, if it is installed.
    size : int
        The width and height of the square picture whose rays are timed.
    budget : float
        Seconds for the rays of one figure; fewer rays are traced if all would take longer.
    build_limit : float
        Seconds; a build that takes longer is aborted.
    lengths : tuple of float
        The piece lengths that are tried for Embree, as fractions of the box's diagonal.
    picture, samples : int
        The width and height of a depth picture in pixels, and the samples of each pixel.
    heat : int
        The width and height of the heat maps.
    panel, levels : int
        The width and height of a level's panel, and the number of levels that are drawn.
    drawn : tuple of str
        The trees whose levels are drawn.
    depths : tuple of int
        The rows of the table of thesis §4.3.
    """

    name: str = sized("full", "quick")
    scenes: Mapping[str, int | None] = sized(dict.fromkeys(NAMES), QUICK_SCENES)
    methods: tuple[str, ...] = (*THESIS_METHODS, DEFAULT_METHOD)
    peer: bool = True
    size: int = sized(512, 256)
    budget: float = sized(1.0, 0.06)
    build_limit: float = sized(120.0, 20.0)
    lengths: tuple[float, ...] = (*LENGTHS, 1 / 256)
    picture: int = sized(400, 240)
    samples: int = sized(4, 2)
    heat: int = sized(256, 128)
    panel: int = sized(200, 160)
    levels: int = 6
    drawn: tuple[str, ...] = ("bvh-cl", "bvh-d2", "kd-d2")
    depths: tuple[int, ...] = (0, 1, 2, 3)
