"""What is chosen on the page: what is shown, and how."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..geometry.hit_places import Float64Array
from .scene_frame import SceneFrame
from .shot import Ray

#: What a click on the page does.
SHOOT, PICK, TURN = "shoots a ray", "picks a leaf", "does nothing"
CLICKS = (SHOOT, PICK, TURN)
#: Which lines are shown.
ALL, TESTED, HITS, NONE = "all", "those that the ray tests", "those that it hits", "none"
LINES = (ALL, TESTED, HITS, NONE)
#: The same, by the words of the command line.
SHOWN = {"all": ALL, "tested": TESTED, "hits": HITS, "none": NONE}
#: The step after which the whole way of a ray is shown.
ALL_STEPS = 2**31
#: The cut planes that hide nothing, as fractions of the box.
UNCUT = ((0.0, 1.0), (0.0, 1.0), (0.0, 1.0))


@dataclass
class Choices:
    """What is chosen. All browsers that show a page share it.

    Attributes
    ----------
    lines : str
        Which lines are shown, one of `LINES`.
    color : str
        What colours of lines depend on.
    brightness, width : float
        Of lines: from 0 to 1, and in pixels of the screen.
    cut : three pairs of floats
        Between which fractions of the box lines are shown, along x, y and z.
    level : int
        The level of the tree whose boxes are shown.
    boxes, planes : bool
        Whether its boxes, and the planes that split them, are shown.
    side : int
        Which tree is shown: 0 for the first, 1 for the second, 2 for both beside each other.
    node : tuple of tree and node, or None
        The node that is picked.
    ray : Ray or None
    radius : float
        How near to the ray lines are hit.
    query : {"all", "first"}
        Whether the ray ends at its first hit.
    step : int
        How many nodes of the ray's way are shown.
    click : str
        What a click does.
    """

    lines: str = ALL
    color: str = "direction"
    brightness: float = 0.7
    width: float = 1.5
    cut: tuple[tuple[float, float], ...] = UNCUT
    level: int = 0
    boxes: bool = True
    planes: bool = False
    side: int = 0
    node: tuple[int, int] | None = None
    ray: Ray | None = None
    radius: float = 0.0
    query: Literal["all", "first"] = "all"
    step: int = ALL_STEPS
    click: str = SHOOT

    def slab(self, frame: SceneFrame) -> Float64Array | None:
        """Return the corners between which lines are shown, (2, 3), without the offset; None if nothing is cut."""
        if self.cut == UNCUT:
            return None
        low, high = frame.box
        fractions = np.array(self.cut).T
        # A plane at the end of the box cuts nothing off, not even by rounding.
        corners = low + fractions * (high - low)
        return np.where(fractions == 0, -np.inf, np.where(fractions == 1, np.inf, corners))
