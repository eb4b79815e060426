"""Cem Yuksel's HAIR files (``.hair``): strands of hair as polylines.

Format: http://www.cemyuksel.com/research/hairmodels, all numbers little-endian. After a header of 128 bytes come the
arrays whose bit is set, in this order: segments per strand, points, thickness, transparency, colours, and texture
coordinates (an extension by LuxCoreRender). A strand has one point more than segments.

The format defines neither units nor axes, nor the meaning of its *thickness*. It is read as the full width, so the
radius is half of it; an importer for Unreal and a converter from Alembic's widths do the same.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...arrays import FLOAT64_ADVICE, warn_of_rounding
from ...geometry.lines import Lines
from ..losses import keeps_values, not_held
from ..polylines import polylines_of
from ..source import Source

_HEADER = np.dtype(
    [
        ("magic", "S4"),
        ("strands", "<u4"),
        ("points", "<u4"),
        ("bits", "<u4"),
        ("segments", "<u4"),  # per strand, without an array of them; the next three likewise per point
        ("thickness", "<f4"),
        ("transparency", "<f4"),
        ("color", "<f4", 3),
        ("info", "S88"),
    ]
)
_SEGMENTS, _POINTS, _THICKNESS, _TRANSPARENCY, _COLORS, _UV = (1 << bit for bit in range(6))
#: The arrays per point that become attributes: their bits, and the shape of each value.
_ATTRIBUTES: dict[str, tuple[int, tuple[int, ...]]] = {
    "transparency": (_TRANSPARENCY, ()),
    "color": (_COLORS, (3,)),
    "uv": (_UV, (2,)),
}
#: The most segments that a strand can have.
_MOST = 65535
_ALL_BITS = _SEGMENTS | _POINTS | _THICKNESS | _TRANSPARENCY | _COLORS | _UV


def read(source: Source, invalid: str) -> Lines:
    """Read a ``.hair`` file.

    ``radius`` (n, 2) is half the thickness of the array, or else half the header's default; None if that is 0. Arrays
    per point become ``attributes`` of the segment that starts there: ``transparency`` (n,), ``color`` (n, 3) and ``uv``
    (n, 2), float32. The header's default colour and transparency are not kept.
    """
    header = source.record("header fields", _HEADER)
    if header["magic"].upper() != b"HAIR":
        raise source.error(f"starts with {header['magic']!r}, a .hair file with b'HAIR'; check the extension")
    bits, n_strands, n_points = header["bits"], header["strands"], header["points"]
    if bits & ~_ALL_BITS or not bits & _POINTS:
        raise source.error(
            f"announces the arrays {bits:#b}; expected 0b10 (points), and nothing above {_ALL_BITS:#b}; "
            "the header is damaged"
        )

    # Read the arrays in the order of the file. That proves the numbers of the header before they are used.
    segments = source.array("segment counts", "<u2", (n_strands,)) if bits & _SEGMENTS else None
    points = source.array("points", "<f4", (n_points, 3))
    thickness = source.array("thicknesses", "<f4", (n_points,)) if bits & _THICKNESS else None
    attributes = {
        name: source.array(name + " values", "<f4", (n_points, *per_point))
        for name, (bit, per_point) in _ATTRIBUTES.items()
        if bits & bit
    }
    source.finish()

    # Count the points of each strand; they must add up.
    if segments is None:
        n_counted = n_strands * (header["segments"] + 1)
    else:
        n_counted = n_strands + int(segments.sum(dtype=np.int64))
    if n_counted != n_points:
        raise source.error(
            f"by their segments, {n_strands} strands have {n_counted} points, but {n_points} are announced; "
            "the header is damaged"
        )
    counts = np.full(n_strands, header["segments"] if segments is None else segments, np.int64) + 1

    # Take the thickness per point, or the default for all; 0 means none.
    radius = None
    if thickness is not None:
        radius = source.radius("thickness", thickness) / 2
    elif header["thickness"] != 0:
        default = source.radius("default thickness", np.array([header["thickness"]])) / 2
        radius = np.repeat(default, n_points)
    return Lines.from_points(
        points, counts, radius=radius, attributes=attributes, offset=source.offset, invalid=invalid
    )


def write(lines: Lines, path: Path) -> list[str]:
    """Write a strand for each polyline, with twice the radius as the thickness.

    The attributes ``transparency`` (m,), ``color`` (m, 3) and ``uv`` (m, 2) are written as float32, if they are known
    at both ends of segments. A polyline of more than 65,535 segments is written as several strands that share a point.
    """
    polylines = polylines_of(lines)
    # Cut polylines that have too many segments.
    n_segments = polylines.counts - 1
    n_parts = (n_segments + _MOST - 1) // _MOST
    counts = np.full(int(n_parts.sum()), _MOST + 1, np.int64)
    last = np.cumsum(n_parts) - 1
    counts[last] = n_segments - (n_parts - 1) * _MOST + 1
    rows = np.arange(len(polylines.points))
    if len(counts) > len(n_parts):
        cuts = np.delete(np.cumsum(counts - 1) + np.repeat(np.arange(len(n_parts)), n_parts), last)
        rows = np.insert(rows, cuts, cuts)

    # Add the arrays in the order of their bits.
    bits = _SEGMENTS | _POINTS
    points = polylines.points[rows].astype("<f4")
    warn_of_rounding(polylines.points[rows], points, FLOAT64_ADVICE)
    arrays = [(counts - 1).astype("<u2"), points]
    if polylines.radius is not None:
        bits |= _THICKNESS
        arrays.append((2 * polylines.radius[rows]).astype("<f4"))
    lost = []
    for name, (bit, per_point) in _ATTRIBUTES.items():
        values = polylines.point_attributes.get(name)
        if values is not None and values.shape[1:] == per_point and values.dtype.kind in "fiub":
            bits |= bit
            with np.errstate(over="ignore"):
                arrays.append(values[rows].astype("<f4"))
            if not keeps_values(values[rows], arrays[-1]):
                lost.append(f"digits of {name!r} ({values.dtype}) beyond float32")
    header = np.zeros((), _HEADER)
    header["magic"], header["strands"], header["points"], header["bits"] = b"HAIR", len(counts), len(rows), bits
    header["color"] = 1
    with path.open("wb") as file:
        file.writelines(array.tobytes() for array in (header, *arrays))
    if len(counts) > len(n_parts):
        lost.append(f"strands of more than {_MOST:,} segments, each of which is written as several strands")
    kept = [name for name, (bit, _) in _ATTRIBUTES.items() if bits & bit]
    return lost + not_held(lines, polylines, radius=True, attributes=kept)
