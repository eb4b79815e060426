"""Curves of the renderer Mitsuba 3 (``.txt``, ``.curves``): what its shapes *linearcurve* and *bsplinecurve* load.

Format: https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_shapes.html#linear-curve-linearcurve. A line has
the position and the radius of a control point, ``x y z radius``. An empty line ends a curve. The file does not say for
which of the two shapes it is.

Mitsuba refuses curves of too few points. Here a lone point of a linear curve is read as a segment of zero length, with
a warning. Numbers after the fourth of a line are not read, with a warning.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...arrays import choice
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ..losses import not_held
from ..polylines import polylines_of
from ..source import Source
from .number_text import first_columns, number_lines, unify, words_of

BASES = ("linear", "bspline")


def read(source: Source, invalid: str, *, basis: str = "linear") -> Lines | Curves:
    """Read a text of curves: `Lines`, or `Curves` of uniform cubic B-splines.

    Parameters
    ----------
    basis : {"linear", "bspline"}
        The shape that the file is for.
    """
    choice("basis", basis, BASES)
    lines = number_lines(source, unify(source.data))
    source.drop()
    table = first_columns(source, lines, "x y z radius")

    # A curve begins at a point that does not follow another one line below it.
    where = np.flatnonzero(lines.counts)
    begins = np.flatnonzero(np.diff(where, prepend=-2) > 1)
    counts = np.diff(np.append(begins, len(where)))
    points, radius = table[:, :3], source.radius("radii", table[:, 3])
    if basis == "linear":
        if n_lone := int((counts == 1).sum()):
            source.warn(f"{n_lone} of its curves have one point, and become segments of zero length")
        return Lines.from_points(points, counts, radius=radius, offset=source.offset, invalid=invalid)
    few = np.flatnonzero(counts < 4)
    if len(few):
        raise source.error(
            f"the curve at line {int(where[begins[few[0]]]) + 1} has {counts[few[0]]} points; a B-spline has 4 or "
            "more; fix the file, or read it with basis='linear'"
        )
    return Curves.from_strands(points, counts, basis=basis, radius=radius, offset=source.offset, invalid=invalid)


def write(lines: Lines, path: Path) -> list[str]:
    """Write a curve for each polyline, for the shape *linearcurve*; the radius is 0 where the lines have none."""
    polylines = polylines_of(lines)
    radius = np.zeros(len(polylines.points), np.float32) if polylines.radius is None else polylines.radius
    table = np.concatenate([polylines.points, radius[:, None]], axis=1)
    ends = iter(np.cumsum(polylines.counts).tolist())
    end, n_written = next(ends, 0), 0
    with path.open("wb") as file:
        for rows in words_of(table):
            for row in rows:
                file.write(b" ".join(row) + b"\n")
                n_written += 1
                if n_written == end and n_written < len(table):
                    file.write(b"\n")
                    end = next(ends)
        if not len(table):
            file.write(b"\n")
    return not_held(lines, polylines, radius=True, needs_radius=True)
