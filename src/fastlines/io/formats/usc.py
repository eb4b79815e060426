"""Hair of the USC-HairSalon database (``.data``).

Format: http://www-scf.usc.edu/~liwenhu/SHM/database.html, all numbers little-endian: an int32 number of strands; then
each strand's int32 number of points and their float32 coordinates. In the database each strand has 1 or 100 points. A
strand of one point says that no hair grows from this root, so it becomes no segment. It keeps its number: the strands
of the lines count all roots. Heads are upright along y. The format defines no unit and no thickness.
"""

from __future__ import annotations

import numpy as np

from ...geometry.lines import Lines
from ..source import Source
from .counted import counted_points


def read(source: Source, invalid: str) -> Lines:
    """Read a ``.data`` file; strands of one point, which mark roots without hair, have no segments."""
    n_strands = int(source.array("counts of strands", "<i4", (1,))[0])
    if n_strands < 0:
        raise source.error(f"announces {n_strands} strands; expected 0 or more; check the extension")
    points, counts = counted_points(source, n_strands)
    bald = counts == 1
    if len(counts) and bald.all():
        source.warn(f"no hair grows from its {len(counts)} roots, so there are no lines")
    return Lines.from_points(
        points[~np.repeat(bald, counts)], np.where(bald, 0, counts), offset=source.offset, invalid=invalid
    )
