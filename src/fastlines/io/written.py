"""What a format cannot hold, in words, as writers return it."""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from ..lines import Lines
from .polylines import Polylines


def is_encodable(name: str) -> bool:
    """Return whether a name can be written as UTF-8, which halves of surrogate pairs cannot."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def not_held(
    lines: Lines,
    polylines: Polylines,
    *,
    radius: bool = False,
    needs_radius: bool = False,
    attributes: Container[str] = (),
    unit: str | None = None,
) -> list[str]:
    """Return what is lost when lines are written as polylines.

    Parameters
    ----------
    radius : bool
        Whether the format has a radius at each point.
    needs_radius : bool
        Whether it has one in any case, so that 0 stands for none.
    attributes : container of str
        The attributes that are written.
    unit : str, optional
        The unit by the format's convention.
    """
    lost = []
    if lines.radius is not None and not radius:
        lost.append("radius")
    if lines.radius is None and needs_radius:
        lost.append("that there is no radius, which is written as 0")
    known = polylines.strand[polylines.strand >= 0]
    if len(known) and not np.array_equal(polylines.strand, np.arange(len(polylines.strand))):
        lost.append("the numbers of strands, which are counted anew")
    names = [*polylines.point_attributes, *polylines.attributes]
    lost += [repr(name) for name in names if name not in attributes]
    lost += [text for text in polylines.lost if radius or not text.startswith("radius ")]
    if lines.unit is not None and lines.unit != unit:
        lost.append(f"the unit, {lines.unit!r}")
    if lines.up is not None:
        lost.append(f"the axis that points upwards, {lines.up!r}")
    return lost
