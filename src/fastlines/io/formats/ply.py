"""Edges of PLY files (``.ply``): text, or binary of either byte order.

Format: https://paulbourke.net/dataformats/ply/. The element ``vertex`` has ``x y z``; the element ``edge`` has
``vertex1 vertex2``. The property ``radius`` of vertices is the radius. Other properties of vertices become attributes
at both ends of segments, and those of edges attributes of segments. Properties ``name_0``, ``name_1``, … of one type
are the columns of one attribute. List properties and other elements are not read; a warning counts the faces.

A strand is a run of edges that each begin at the vertex at which the one before ends. An integer property ``strand`` of
edges overrides that. The format defines no unit and no axes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import STRAND_LIMIT, IntArray
from ...geometry.lines import Lines
from ...support.texts import kinds_text
from ..losses import not_held, strand_numbers
from ..polylines import polylines_of
from ..source import Source
from .ply_elements import TYPES, Columns, read_elements

#: The types that are written for those that PLY does not have.
_WRITTEN = {"b1": "u1", "f2": "f4", "i8": "i4", "u8": "u4"}
_PLY_NAMES = {code: name for name, code in reversed(TYPES.items()) if not name[-1].isdigit()}
_VERTEX: tuple[str, ...] = ("x", "y", "z")
_EDGE: tuple[str, ...] = ("vertex1", "vertex2")
#: The columns that are not attributes.
_VERTEX_USED, _EDGE_USED = (*_VERTEX, "radius"), (*_EDGE, "strand")


def read(source: Source, invalid: str) -> Lines:
    """Read the edges of a ``.ply`` file."""
    elements = read_elements(source, ("vertex", "edge"))
    if n_faces := elements.counts.get("face", 0):
        source.warn(f"its {n_faces} faces are not read; only its edges are lines")
    if not elements.counts.get("edge"):
        n_vertices = elements.counts.get("vertex", 0)
        others = {name: n for name, n in elements.counts.items() if n and name not in ("vertex", "face", "edge")}
        if n_vertices and not n_faces:
            source.warn(f"its {n_vertices} vertices are not read, as no edge joins them")
        elif others and not n_faces:
            source.warn(f"its elements are not read, as none is an edge: {kinds_text(others)}")
        return Lines.from_segments(np.empty((0, 2, 3)))
    vertices, edges = elements.columns.get("vertex", {}), elements.columns["edge"]
    for element, columns, names in (("vertex", vertices, _VERTEX), ("edge", edges, _EDGE)):
        missing = [name for name in names if name not in columns]
        if missing:
            raise source.error(
                f"its element {element!r} has no number {missing[0]!r} (it has {', '.join(columns)[:80] or 'none'}); "
                f"expected {', '.join(names)}"
            )
    points = np.stack([vertices[name] for name in _VERTEX], axis=1)
    ends = _ends(source, edges, len(points))

    # Gather what is known of vertices at both ends.
    radius = source.radius("radii", vertices["radius"])[ends] if "radius" in vertices else None
    at_ends = {name: values[ends] for name, values in _grouped(vertices, _VERTEX_USED).items()}
    strands = edges.get("strand")
    if strands is None or strands.dtype.kind not in "iu" or (strands >= STRAND_LIMIT).any():
        strands = _runs(ends)
        used = _EDGE
    else:
        used = _EDGE_USED
    attributes = {
        f"{name} of edge" if name in at_ends else name: values for name, values in _grouped(edges, used).items()
    }
    return Lines.from_segments(
        points[ends],
        strands=strands.astype(np.int64),
        radius=radius,
        attributes=attributes,
        end_attributes=at_ends,
        offset=source.offset,
        invalid=invalid,
    )


def write(lines: Lines, path: Path) -> list[str]:
    """Write binary vertices and edges with all attributes of numbers; each polyline has vertices of its own.

    Whole numbers of 64 bits are written as 32 bits. Strands are written if they are not the runs of edges.
    """
    polylines = polylines_of(replace(lines, attributes={}))
    vertices: Columns = {name: polylines.points[:, i] for i, name in enumerate(_VERTEX)}
    if polylines.radius is not None:
        vertices["radius"] = polylines.radius
    kept, lost = _add_attributes(vertices, _VERTEX_USED, polylines.point_attributes)
    last = np.zeros(len(polylines.points), np.bool_)
    last[polylines.offsets[1:] - 1] = True
    first = np.flatnonzero(~last)
    edges: Columns = {"vertex1": first, "vertex2": first + 1}
    if unlike := strand_numbers(polylines.strand):
        if lines.strands.max() <= np.iinfo(np.int32).max:
            edges["strand"] = lines.strands
        else:
            lost += unlike
    others = {name: values for name, values in lines.attributes.items() if name not in lines.end_attributes}
    lost += _add_attributes(edges, _EDGE_USED, others)[1]
    with path.open("wb") as file:
        header = ["ply", "format binary_little_endian 1.0"]
        bodies = []
        for element, columns in (("vertex", vertices), ("edge", edges)):
            table = _table(columns)
            header.append(f"element {element} {len(table)}")
            header += [f"property {_PLY_NAMES[table.dtype[name].str[1:]]} {name}" for name in table.dtype.names or ()]
            bodies.append(table.tobytes())
        file.write("\n".join([*header, "end_header\n"]).encode())
        file.writelines(bodies)
    # Of attributes that are not written, `lost` has more than the names.
    held = not_held(lines, polylines, radius=True, attributes=kept, strands=True)
    return lost + [text for text in held if text not in map(repr, polylines.point_attributes)]


def _ends(source: Source, edges: Columns, n_vertices: int) -> IntArray:
    """Return the vertices of edges, (n, 2), which must be there."""
    given = np.stack([edges[name] for name in _EDGE], axis=1)
    with np.errstate(invalid="ignore"):
        bad = np.flatnonzero(~((given >= 0) & (given < n_vertices) & (given == np.floor(given))).all(axis=1))
    if len(bad):
        raise source.error(
            f"edge {bad[0]} joins the vertices {given[bad[0], 0]:g} and {given[bad[0], 1]:g}; expected 0 to "
            f"{n_vertices - 1}; fix the file"
        )
    return given.astype(np.int64)


def _runs(ends: IntArray) -> IntArray:
    """Number the runs of edges that begin where the one before ends."""
    begins = np.ones(len(ends), np.int64)
    begins[1:] = ends[1:, 0] != ends[:-1, 1]
    return np.cumsum(begins) - 1


def _grouped(columns: Columns, used: tuple[str, ...]) -> Columns:
    """Return the columns that are not used otherwise; those named name_0, name_1, … as one of several columns."""
    left = {name: values for name, values in columns.items() if name not in used}
    parts: dict[str, list[str]] = {}
    for name, values in left.items():
        stem, _, number = name.rpartition("_")
        if number == "0" and stem and stem not in columns:
            names = [name]
            while (more := left.get(f"{stem}_{len(names)}")) is not None and more.dtype == values.dtype:
                names.append(f"{stem}_{len(names)}")
            if len(names) > 1:
                parts[name] = names
    joined = {name for names in parts.values() for name in names}
    grouped: Columns = {}
    for name, values in left.items():
        if name in parts:
            grouped[name.removesuffix("_0")] = np.stack([left[part] for part in parts[name]], axis=1)
        elif name not in joined:
            grouped[name] = values
    return grouped


def _add_attributes(
    columns: Columns, used: tuple[str, ...], attributes: Mapping[str, npt.NDArray[Any]]
) -> tuple[set[str], list[str]]:
    """Add the columns of attributes to those of an element; return the names of these attributes, and what is lost."""
    lost: list[str] = []
    shapes: dict[str, tuple[int, ...]] = {}
    for name, values in attributes.items():
        code = values.dtype.str[1:]
        code = _WRITTEN.get(code, code)
        fits = code in _PLY_NAMES and values.ndim <= 2 and 0 not in values.shape[1:] and re.fullmatch(r"[!-~]+", name)
        if not fits:
            lost.append(f"{name!r} ({values.dtype} of shape {values.shape})")
            continue
        with np.errstate(over="ignore", invalid="ignore"):
            written = values.astype(code)
        if code[0] in "iu" and not np.array_equal(written, values):
            lost.append(f"{name!r} ({values.dtype} of shape {values.shape})")
            continue
        if written.shape[1:] == (1,):
            lost.append(f"the shape {values.shape} of {name!r}, which is written as one column")
            written = written[:, 0]
        parts = {name: written} if written.ndim == 1 else {f"{name}_{i}": part for i, part in enumerate(written.T)}
        if any(part in columns or part in used for part in parts):
            lost.append(f"{name!r}, whose name stands for another property")
            continue
        columns |= parts
        shapes[name] = written.shape
    read = _grouped(columns, used)
    joined = [name for name, shape in shapes.items() if name not in read or read[name].shape != shape]
    lost += [f"that {name!r} is an attribute, as names with _0, _1, … are of columns of one" for name in joined]
    return set(shapes), lost


def _table(columns: Columns) -> npt.NDArray[Any]:
    """Return columns as rows of packed little-endian numbers."""
    codes = {name: _WRITTEN.get(values.dtype.str[1:], values.dtype.str[1:]) for name, values in columns.items()}
    table = np.zeros(len(next(iter(columns.values()))), [(name, "<" + code) for name, code in codes.items()])
    for name, values in columns.items():
        table[name] = values
    return table
