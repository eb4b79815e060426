"""Neurons (``.swc``): trees of points, each with its radius and its parent.

Format: http://www.neuronland.org/NLMorphologyConverter/MorphologyFormats/SWC/Spec.html. A line is a node,
``id type x y z radius parent``, in micrometres; ``#`` begins a comment. A segment joins a node to its parent, with the
radius at both ends. A strand is an unbranched section. A root without children is a segment of zero length.

The comment ``# OFFSET x y z``, by which Janelia's workstation keeps coordinates small, is added to them. ``SCALE`` and
``SHRINKAGE_CORRECTION`` are not used, nor is another unit in the comments; a warning says so.

Segments are as the file has them: those between a soma's point and the dendrites at it too, and in the three-point
soma those from node 1 to the other two. Files in the wild have nodes in any order, several roots, parents that are not
there, cycles, and ids that repeat. What has one meaning is read, and what is odd gives a warning.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray, IntArray
from ...geometry.lines import Lines
from ...geometry.offsets import in_file
from ...geometry.sections import count_rootless, find_sections
from ...support.distinct import distinct, is_among
from ..losses import not_held, strand_numbers
from ..polylines import Polylines, polylines_of
from ..source import Source
from .number_text import Float64Array, first_columns, number_lines, one_each, parse_numbers, unify, words_of

UNIT = "µm"
_COMMENT = re.compile(rb"#[^\n]*")
#: Comments that change what coordinates mean: a word, and numbers.
_WORDS = re.compile(rb"^[ \t]*#+[ \t]*(OFFSET|SCALE|SHRINKAGE[_ ]CORRECTION)\b([^\n]*)", re.IGNORECASE | re.MULTILINE)
#: What may stand around these numbers.
_BETWEEN = re.compile(rb"[\s,;:=()\[\]]+|(?<![\w.])[XYZ](?![\w.])", re.IGNORECASE)
_UNITS = re.compile(
    rb"^[ \t]*#(?:[^\n]*\"units?\"\s*:\s*\"(?:1 )?([^\"\n]*)\"|[# \t]*+units?[ \t:=]++([^\s,;.]++)[ \t]*+$)",
    re.IGNORECASE | re.MULTILINE,
)
#: What files call the unit of the format.
_MICRONS = ("µm", "μm", "um", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres")
#: The largest whole number up to which float64 holds all of them.
_LARGEST_ID = 2**53


def read(source: Source, invalid: str) -> Lines:
    """Read a ``.swc`` file; ``id`` and ``type`` of both ends of each segment become ``end_attributes``.

    The first end of a segment is the parent. Sections are numbered in the order in which the file begins them.
    """
    text = unify(source.data)
    offset = _offset(source, text)
    lines = number_lines(source, text, comment=_COMMENT if b"#" in text else None)
    del text
    source.drop()
    table = first_columns(source, lines, "id type x y z radius parent")
    line_of = np.flatnonzero(lines.counts) + 1
    ids, types, parents = (
        _whole(source, table[:, column], name, line_of) for column, name in ((0, "id"), (1, "type"), (6, "parent"))
    )
    radius = source.radius("radii", table[:, 5])
    points = table[:, 2:5] + offset if offset.any() else table[:, 2:5]  # which keeps -0
    parent = _find_parents(source, ids, parents, table, line_of)

    # Make one segment for each node with a parent, and for each root without children.
    has_children = np.zeros(len(ids), np.bool_)
    has_children[parent[parent >= 0]] = True
    child = np.flatnonzero((parent >= 0) | ~has_children)
    parent = np.where(parent < 0, np.arange(len(ids)), parent)
    if n_rootless := count_rootless(parent):
        source.warn(f"{n_rootless} of its nodes descend from no root, but from a cycle; all segments are read")
    first, sections, order = find_sections(parent, child)
    ends = np.stack([first, child], axis=1)[order]
    return Lines.from_segments(
        points[ends],
        strands=sections,
        radius=radius[ends],
        end_attributes={"id": ids[ends], "type": types[ends]},
        offset=source.offset,
        invalid=invalid,
    )


class Nodes(NamedTuple):
    """Nodes of trees, a row for each: its id, the id of its parent or -1, its point, radius and type."""

    ids: IntArray
    parents: IntArray
    points: AnyArray
    radius: FloatArray
    types: IntArray


def write(lines: Lines, path: Path) -> list[str]:
    """Write the nodes of `nodes_of`. The radius is 0 where the lines have none."""
    polylines = polylines_of(lines)
    nodes, kept = nodes_of(lines, polylines)
    table = np.concatenate([nodes.points, nodes.radius[:, None]], axis=1)
    numbers = (one_each(np.asarray(values)) for values in (nodes.ids, nodes.types, nodes.parents))
    with path.open("wb") as file:
        file.write(b"# id type x y z radius parent\n")
        rows = (row for rows in words_of(table) for row in rows)
        for node, kind, parent, row in zip(*numbers, rows, strict=True):
            file.write(b" ".join([node, kind, *row, parent]) + b"\n")
    lost = _reordered(lines, nodes) if "id" in kept else strand_numbers(polylines.strand)
    held = not_held(lines, polylines, radius=True, needs_radius=True, attributes=kept, strands=True, unit=UNIT)
    return lost + held


def nodes_of(lines: Lines, polylines: Polylines) -> tuple[Nodes, list[str]]:
    """Return a node for each point of the polylines of lines, and the names of the attributes that nodes keep.

    Each polyline is a tree of its own. Where all ends of segments have an ``id``, as lines from a ``.swc`` file do,
    nodes are these ids, which rise, and so the trees stay whole. The type is that of the attribute ``type``, or 0.
    """
    types = polylines.point_attributes.get("type")
    has_types = types is not None and types.ndim == 1 and types.dtype.kind in "iu"
    kept = ["type"] * has_types
    nodes = _nodes_by_id(lines, lines.end_attributes["type"] if has_types else None)
    if nodes is not None:
        return nodes, [*kept, "id"]
    m = len(polylines.points)
    parents = np.arange(m)
    parents[polylines.offsets[:-1]] = -1
    radius = np.zeros(m, np.float32) if polylines.radius is None else polylines.radius
    kinds = np.zeros(m, np.int64) if types is None or not has_types else types
    return Nodes(np.arange(1, m + 1), parents, polylines.points, radius, kinds), kept


def _offset(source: Source, text: bytes) -> Float64Array:
    """Return what the comment OFFSET adds to coordinates, (3,); warn of comments that say more and are not used."""
    offset = np.zeros(3)
    found: dict[str, Float64Array] = {}
    for word, rest in _WORDS.findall(text):
        name, words = word.decode().upper().replace(" ", "_"), _BETWEEN.sub(b" ", rest).split()
        if not words or parse_numbers(words[0]) is None:
            continue  # prose that begins with the word
        numbers = parse_numbers(b" ".join(words))
        if numbers is not None and len(numbers) == 1 and name != "OFFSET":
            numbers = np.repeat(numbers, 3)
        if numbers is None or len(numbers) != 3 or not np.isfinite(numbers).all():
            shown = f"{name}{rest.decode('utf-8', 'replace').rstrip()}"[:60]
            source.warn(f"its comment {shown!r} does not have three numbers alone, and is not used")
            continue
        if not np.array_equal(found.setdefault(name, numbers), numbers):
            source.warn(f"has several comments {name}; only the first is used")
    for name, numbers in found.items():
        if name == "OFFSET":
            offset = numbers
        elif (numbers != 1).any():
            factors = " ".join(f"{factor:g}" for factor in numbers)
            source.warn(f"its comment {name} is {factors}; coordinates are not scaled by it")
    units = {b"".join(words).decode("utf-8", "replace").strip() for words in _UNITS.findall(text)}
    if wrong := sorted(unit for unit in units if unit.lower() not in _MICRONS):
        source.warn(f"its comments say that the unit is {wrong[0]!r}; by the format, µm is taken")
    return offset


def _whole(source: Source, values: Float64Array, name: str, line_of: IntArray) -> IntArray:
    """Return a column of whole numbers."""
    with np.errstate(invalid="ignore"):
        bad = np.flatnonzero(~((np.abs(values) <= _LARGEST_ID) & (values == np.round(values))))
    if len(bad):
        raise source.error(
            f"line {line_of[bad[0]]}: the {name} is {values[bad[0]]:g}; expected a whole number; fix the line"
        )
    return values.astype(np.int64)


def _find_parents(source: Source, ids: IntArray, parents: IntArray, table: Float64Array, line_of: IntArray) -> IntArray:
    """Return the row of each node's parent; -1 for a root."""
    order = np.argsort(ids, kind="stable")
    sorted_ids = ids[order]
    place = np.searchsorted(sorted_ids, parents)
    there = (place < len(ids)) & (parents >= 0)
    there[there] = sorted_ids[place[there]] == parents[there]
    parent = np.full(len(ids), -1)
    parent[there] = order[place[there]]

    # An id that repeats is a parent only if all its nodes are in the same place.
    again = np.flatnonzero(sorted_ids[1:] == sorted_ids[:-1]) + 1
    if len(again):
        same = (table[order[again], 2:6] == table[order[again - 1], 2:6]).all(axis=1)
        unclear = again[~same & is_among(sorted_ids[again], parents[there])]
        if len(unclear):
            lines = line_of[order[unclear[0] - 1 : unclear[0] + 1]]
            raise source.error(
                f"the id {sorted_ids[unclear[0]]} stands on lines {lines[0]} and {lines[1]} for different nodes, and "
                "is a parent; which one is not known: fix the file"
            )
        source.warn(f"{len(again)} of its nodes have the id of an earlier one; all are read")
    is_self = parent == np.arange(len(ids))
    if is_self.any():
        source.warn(f"{int(is_self.sum())} of its nodes are their own parents; they are read as roots")
    n_missing = int((~there & (parents >= 0)).sum())
    if n_missing:
        source.warn(f"the parents of {n_missing} of its nodes are not there; these nodes are read as roots")
    return np.where(is_self, -1, parent)


def _nodes_by_id(lines: Lines, given_types: npt.NDArray[Any] | None) -> Nodes | None:
    """Return the nodes, if the ends of segments have ids that make trees."""
    ends = lines.end_attributes.get("id")
    if ends is None or ends.shape != (len(lines), 2) or ends.dtype.kind not in "iu":
        return None
    if not len(lines) or (ends < 0).any() or (ends > _LARGEST_ID).any():
        return None
    types = np.zeros_like(ends) if given_types is None else given_types
    flat = ends.reshape(-1).astype(np.int64)
    ids, first, node = np.unique(flat, return_index=True, return_inverse=True)
    points, radius, kinds = (
        in_file(lines, lines.segments).reshape(-1, 3),
        lines.end_radii.reshape(-1),
        types.reshape(-1),
    )
    if not all(np.array_equal(values, values[first][node]) for values in (points, radius, kinds)):
        return None
    parents = np.full(len(ids), -1)
    is_root = ends[:, 0] == ends[:, 1]
    children = node.reshape(-1, 2)[~is_root, 1]
    if len(distinct(ends[:, 1])) < len(ends) or is_root[is_among(ends[:, 0], ends[~is_root])].any():
        return None
    parents[children] = ends[~is_root, 0]
    return Nodes(np.asarray(ids), parents, points[first], radius[first], kinds[first].astype(np.int64))


def _reordered(lines: Lines, nodes: Nodes) -> list[str]:
    """Return what is lost as sections of nodes, whose ids rise, are read in another order or as other strands."""
    ids, parents = nodes.ids, nodes.parents
    is_root = parents < 0
    parent = np.where(is_root, np.arange(len(ids)), np.searchsorted(ids, parents))
    has_children = is_among(np.arange(len(ids)), parent[~is_root])
    child = np.flatnonzero(~is_root | ~has_children)
    _, sections, order = find_sections(parent, child)
    # Each segment is the only one that ends at its node.
    given, read = lines.end_attributes["id"][:, 1], ids[child[order]]
    lost = [] if np.array_equal(given, read) else ["the order of segments"]
    strands = lines.strands[np.argsort(given)]
    if (strands < 0).any():
        lost.append("that segments have no strand")
    if ((strands >= 0) & (strands != sections[np.argsort(read)])).any():
        lost.append("the numbers of strands, which are those of sections")
    return lost
