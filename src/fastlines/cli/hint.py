"""A hint for queries in which hardly any ray hits: a radius with which more rays would."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from ..forest.forest import AnyTree
from ..query.rays import seen_of
from ..rendering.suitable_radius import least_radius, some_rays
from .files import note

#: The radius may be too small if less than this fraction of the rays that cross the box of the lines hit.
FEW = 0.01


def hint_at_radius(
    tree: AnyTree,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: float,
    parts: tuple[int, ...] | None = None,
    **bounds: Any,
) -> None:
    """Note a radius that suits if hardly any of the rays that cross the box of the lines hit with this one."""
    if not any(part.takes_radius for part in seen_of(tree.geometry, parts)):
        return
    rays = some_rays(tree, origins, directions, **bounds)
    if rays is None:
        return
    asked = {**bounds, "parts": parts}
    found = float(tree.any_hit(rays[0], rays[1], radius, **asked).mean())
    if found >= FEW:
        return
    larger, suits = least_radius(tree, rays, radius, **asked)
    if larger is not None:
        note(
            f"hardly any ray hits: {found:.1%} of those that cross the box of the lines, with the radius "
            f"{radius:g}; with {larger:g} it would be {suits:.0%}"
        )
