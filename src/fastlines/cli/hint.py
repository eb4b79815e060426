"""A hint for queries in which hardly any ray hits: a radius with which more rays would."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from ..rendering.suitable_radius import least_radius, some_rays
from ..tree import Tree
from .files import note

#: The radius may be too small if less than this fraction of the rays that cross the box of the lines hit.
FEW = 0.01


def hint_at_radius(tree: Tree, origins: npt.ArrayLike, directions: npt.ArrayLike, radius: float, **bounds: Any) -> None:
    """Note a radius that suits if hardly any of the rays that cross the box of the lines hit with this one."""
    rays = some_rays(tree, origins, directions, **bounds)
    if rays is None:
        return
    found = float(tree.any_hit(rays[0], rays[1], radius, **bounds).mean())
    if found >= FEW:
        return
    larger, suits = least_radius(tree, rays, radius, **bounds)
    if larger is not None:
        note(
            f"hardly any ray hits: {found:.1%} of those that cross the box of the lines, with the radius "
            f"{radius:g}; with {larger:g} it would be {suits:.0%}"
        )
