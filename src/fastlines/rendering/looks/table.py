"""The looks by name, and the one that suits a geometry."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arrays import choice, did_you_mean
from ...curves import Curves
from ...errors import InputError
from ...geometry import AnyGeometry, parts_of, radius_beyond
from ...lines import Lines
from ...places import names
from ..lighting import SOFT
from ..vectors import dot, unit
from . import flat
from .color import DISPLAY_COLOR, Color, check_color
from .look import Backdrop, Look
from .solid import Solid

#: The looks, and half a line about each.
LOOKS = {
    "hair": "hair and fur, with highlights and light that passes through",
    "fibre": "tracts, streamlines and wires, coloured by direction",
    "tube": "solid lines, for neurons, yarns and molecules",
    "depth": "lighter is nearer, as in the thesis",
    "id": "a colour for each strand",
    "normal": "the normals as the camera sees them",
    "tangent": "the directions of the lines as the camera sees them",
}
#: How exact light is: scattered once and then as an estimate, or by paths of many bounces.
QUALITIES = ("normal", "high")
#: At least so many strands look like hair, if nothing says otherwise.
HAIRS = 1000

#: Half of the turns of hair have a larger cosine.
SMOOTH = 0.8

PAPER = Backdrop((0.93, 0.93, 0.94), (0.78, 0.78, 0.80))
NIGHT = Backdrop((0.075, 0.08, 0.095), (0.03, 0.032, 0.04))
CLAY = (0.62, 0.50, 0.36)


def look_for(geometry: AnyGeometry) -> str:
    """Choose the look of a geometry.

    Lines with a radius are tubes, and so are all other shapes. Of lines without one, thousands of strands that are not
    flat and without a unit, or in metres, are hair. Other lines are fibres.

    Examples
    --------
    >>> import fastlines as fl
    >>> look_for(fl.scenes.make("bun-hair").lines), look_for(fl.lines([[[0, 0, 0], [1, 1, 1]]]))
    ('hair', 'fibre')
    """
    parts = parts_of(geometry)
    if radius_beyond(geometry) > 0 or not all(isinstance(part, Lines | Curves) for part in parts):
        return "tube"
    lines = [part for part in parts if isinstance(part, Lines | Curves)]
    strands = sum(part.n_strands for part in lines)
    units = [part.unit for part in lines if part.unit]
    unit = units[0] if units else None
    if unit == "Å":
        return "tube"
    is_flat = len(geometry) == 0 or bool((geometry.bounds[1] == geometry.bounds[0]).any())
    is_hair = strands >= HAIRS and not is_flat and unit in (None, "m", "cm") and all(map(_is_smooth, parts))
    return "hair" if is_hair else "fibre"


def _is_smooth(part: AnyGeometry) -> bool:
    """Return whether strands go on in almost the same direction from segment to segment, as hair does."""
    if not isinstance(part, Lines):
        return True
    edges = part.segments[:, 1] - part.segments[:, 0]
    joined = (part.strands[1:] == part.strands[:-1]) & (part.segments[1:, 0] == part.segments[:-1, 1]).all(axis=1)
    one, other = unit(edges[:-1][joined]), unit(edges[1:][joined])
    return len(one) > 0 and float(np.median(dot(one, other))) > SMOOTH


def make_look(
    name: str | None,
    geometry: AnyGeometry,
    color: str | None = None,
    map: str = "viridis",
    quality: str = "normal",
    **options: Any,
) -> Look:
    """Make a look by its name, or the one that suits the geometry."""
    name = name or look_for(geometry)
    if name not in LOOKS:
        raise InputError(f"there is no look {name!r}{did_you_mean(name, tuple(LOOKS))}")
    choice("quality", quality, QUALITIES)
    if name == "hair":
        from ..hair import HairMaterial
        from .hair import Hair
        from .traced_hair import TracedHair

        kind = TracedHair if quality == "high" else Hair
        return kind(HairMaterial.from_melanin(0.55, redness=0.25), PAPER)
    if quality == "high":
        raise InputError(f"quality='high' is for the look 'hair', and this is {name!r}; leave quality out")
    known = {attribute for part in parts_of(geometry) for attribute in names(part)}
    if name in ("fibre", "tube"):
        by = color or (DISPLAY_COLOR if DISPLAY_COLOR in known else "direction" if name == "fibre" else "plain")
        chosen = Color(by, map, CLAY)
        check_color(chosen, geometry)
        return Solid(chosen, NIGHT, SOFT, haze=0.5) if name == "fibre" else Solid(chosen, PAPER)
    shown = {"depth": flat.depth, "id": flat.ids, "normal": flat.normals, "tangent": flat.tangents}
    return flat.Flat(shown[name])
