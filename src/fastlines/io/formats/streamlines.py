"""What formats of streamlines share: millimetres, axes to the Right, Anterior and Superior, values per streamline."""

from __future__ import annotations

from ...arrays import AnyArray
from ..polylines import Polylines

UNIT = "mm"
UP = "z"
#: What follows the name of a value per streamline that a value per point has too.
OF_STREAMLINE = " of streamline"


def split_values(lines: Polylines) -> tuple[dict[str, AnyArray], dict[str, AnyArray], list[str]]:
    """Return the values per point, the radius among them, those per polyline, and what is lost by that, in words."""
    per_point, lost = dict(lines.point_attributes), list(lines.lost)
    if lines.radius is not None:
        name = "radius"
        while name in per_point or name in lines.attributes:
            name += "_"
        per_point[name] = lines.radius
        lost.append(f"that {name!r} is the radius, and not just a value per point")
    # Readers tell values of streamlines from those of points by a longer name.
    names = {name: name.removesuffix(OF_STREAMLINE) for name in lines.attributes}
    per_strand = {
        short if short in per_point and short not in lines.attributes else name: lines.attributes[name]
        for name, short in names.items()
    }
    return per_point, per_strand, lost
