"""Binary Curve Collections (``.bcc``): the yarns of knitted cloth.

Format: http://www.cemyuksel.com/research/yarnmodels/ and http://www.cemyuksel.com/cyCodeBase/soln/using_bcc_files.html

All numbers little-endian. A header of 64 bytes names the type of the curves and the axis that points upwards. Then each
curve has an int32 number of control points, negative for a closed one, and their float32 coordinates.

The type of the published files is ``C0``: Catmull-Rom splines with uniform knots, which are read as such. ``PL`` is a
polyline in files of the YarnBall simulator. Where an open spline ends is not defined; here it begins at its first point
and ends at its last, as Catmull-Rom splines that are *pinned* do in USD. A closed curve joins its last point to its
first. The header's 40 bytes of text are not read, and there is no thickness.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import IntArray, choice
from ...geometry.curves import Curves
from ...geometry.lines import AXES, Lines
from ..source import Source
from .counted import counted_points

_HEADER = np.dtype(
    [
        ("magic", "S3"),
        ("bytes", "u1"),  # of an integer, and of a coordinate, 4 bits each
        ("type", "S2"),
        ("dimensions", "u1"),
        ("up", "u1"),
        ("curves", "<u8"),
        ("points", "<u8"),
        ("info", "S40"),
    ]
)
_BASES = {b"C0": "catmull-rom", b"PL": "linear"}


def read(source: Source, invalid: str, *, basis: str | None = None) -> Lines | Curves:
    """Read a ``.bcc`` file: `Curves` of Catmull-Rom splines, or `Lines` of polylines.

    Parameters
    ----------
    basis : {"catmull-rom", "linear"}, optional
        What the control points mean, instead of what the header says: "linear" joins them by segments.
    """
    if basis is not None:
        choice("basis", basis, _BASES.values())
    header = source.record("header fields", _HEADER)
    if header["magic"] != b"BCC":
        raise source.error(f"starts with {header['magic']!r}, a .bcc file with b'BCC'; check the extension")
    if header["bytes"] != 0x44 or header["dimensions"] != 3:
        raise source.error(
            f"has numbers of {header['bytes'] >> 4} and {header['bytes'] & 15} bytes and {header['dimensions']} "
            "dimensions; expected 4 and 4 bytes and 3 dimensions; convert it"
        )
    if basis is None and header["type"] not in _BASES:
        raise source.error(
            f"holds curves of type {header['type']!r}; expected b'C0', uniform Catmull-Rom splines, or b'PL', "
            "polylines; read it with basis='linear' to join the control points by segments"
        )
    basis = basis or _BASES[header["type"]]
    points, counts = counted_points(source, header["curves"], negative=True)
    if header["points"] != len(points):
        source.warn(f"its header counts {header['points']} points, but its curves have {len(points)}; these are read")
    if header["up"] not in range(3):
        source.warn(f"its header says that axis {header['up']} points upwards; expected 0, 1 or 2, so none is assumed")
    up = AXES[header["up"]] if header["up"] in range(3) else None
    closed, sizes = counts < 0, np.abs(counts)
    if basis == "linear":
        rows, n_rows = _extended(sizes, np.zeros_like(sizes), (closed & (sizes > 1)).astype(np.int64))
        return replace(Lines.from_points(points[rows], n_rows, offset=source.offset, invalid=invalid), up=up)

    # Put a point in front of each curve, and one behind it, or two to close it; a lone point is four times the same.
    rows, n_rows = _extended(sizes, np.minimum(sizes, 1), np.where(sizes > 0, 1 + (closed | (sizes == 1)), 0))
    control = points[rows].astype(np.float64)
    is_open = ~closed & (sizes > 1)
    first = (np.cumsum(n_rows) - n_rows)[is_open]
    last = (np.cumsum(n_rows) - 1)[is_open]
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and Inf are reported with their rows
        control[first] = 2 * control[first + 1] - control[first + 2]
        control[last] = 2 * control[last - 1] - control[last - 2]
    return Curves.from_strands(control, n_rows, basis=basis, up=up, offset=source.offset, invalid=invalid)


def _extended(sizes: IntArray, n_before: IntArray, n_after: IntArray) -> tuple[IntArray, IntArray]:
    """Return the points of each curve, with `n_before` and `n_after` more around it, as of a ring; and how many."""
    n_rows = n_before + sizes + n_after
    start = np.repeat(np.cumsum(sizes) - sizes, n_rows)
    local = np.arange(int(n_rows.sum())) - np.repeat(np.cumsum(n_rows) - n_rows + n_before, n_rows)
    return start + local % np.repeat(np.maximum(sizes, 1), n_rows), n_rows
