"""The plan of a forest: its frame, the columns of all chunks, and the halves of the scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ...arrays import AnyArray, FloatArray, IntArray
from ...errors import FileWarning
from ...geometry.offsets import OFFSET
from ...support.warn_caller import warn_caller
from .budget import Budget
from .halving import Halving, centroids_of, n_leaves_for, n_samples, sampled
from .journal import Journal
from .rows import MISSING, Column, Rows
from .stage_file import read_stage, write_stage


@dataclass(frozen=True)
class Plan:
    """What is known before the chunks are partitioned.

    Attributes
    ----------
    frame : (2, 3) float32
        The box of all segments; zeros if there are none.
    halving : Halving
        The leaves of the scene.
    schema : mapping of str to Column
        The columns of all tiles.
    facts : mapping
        ``up``, ``unit`` and ``metadata`` of the forest.
    first : (n_chunks + 1,) int64
        The number of the first segment of each chunk, and the number of all.
    batches : (n_parts + 1,) int64
        The first chunk of each part.
    n_numbers, n_strands : int
        The number of numbers of strands, some of which may have lost all segments, and of the strands.
    most : int
        The most segments of a tile.
    """

    frame: FloatArray
    halving: Halving
    schema: dict[str, Column]
    facts: dict[str, Any]
    first: IntArray
    batches: IntArray
    n_numbers: int
    n_strands: int
    most: int

    @property
    def n_prims(self) -> int:
        """The number of all segments."""
        return int(self.first[-1])

    @property
    def n_parts(self) -> int:
        """The number of parts."""
        return len(self.batches) - 1

    def write(self, journal: Journal) -> None:
        """Write the file of the plan."""
        cuts = {"axis": self.halving.axis, "place": self.halving.place, "children": self.halving.children}
        schema = {name: [of.dtype.str, of.row, of.of_texts] for name, of in self.schema.items()}
        counts = {"n_numbers": self.n_numbers, "n_strands": self.n_strands, "most": self.most}
        facts = {"schema": schema, "facts": self.facts, **counts}
        arrays: dict[str, AnyArray] = {"frame": self.frame, "first": self.first, "batches": self.batches}
        write_stage(journal.plan, arrays | cuts, facts)

    @classmethod
    def read(cls, journal: Journal) -> Plan:
        """Read the file of the plan."""
        arrays, facts = read_stage(journal.plan)
        halving = Halving(arrays["axis"], arrays["place"], arrays["children"])
        schema = {name: Column(np.dtype(d), tuple(row), text) for name, (d, row, text) in facts["schema"].items()}
        return cls(
            np.array(arrays["frame"]),
            halving,
            schema,
            facts["facts"],
            np.array(arrays["first"]),
            np.array(arrays["batches"]),
            facts["n_numbers"],
            facts["n_strands"],
            facts["most"],
        )


def make_plan(journal: Journal, budget: Budget) -> Plan:
    """Make the plan of the chunks of a journal, or read it if it is there."""
    if journal.plan.exists():
        return Plan.read(journal)
    totals = read_stage(journal.spilled)[1]
    headers, schemas = [], []
    for number in range(totals["n_chunks"]):
        arrays, facts = read_stage(journal.chunk(number))
        headers.append(facts)
        schemas.append(Rows.of_sections(arrays).schema)
    sizes = np.array([header["n_prims"] for header in headers], np.int64)
    filled = [i for i, size in enumerate(sizes) if size] or [0]
    boxes = np.array([headers[i]["box"] or np.zeros((2, 3)) for i in filled], np.float32)
    first = np.concatenate([[0], np.cumsum(sizes)])
    schema = _shared([schemas[i] for i in filled])
    most = budget.most_of(_row_bytes(schema))
    plan = Plan(
        np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]),
        _halving(journal, first, most),
        schema,
        _common([headers[i]["facts"] for i in filled]),
        first,
        _batches(sizes, budget.n_rows),
        totals["n_numbers"],
        totals["n_strands"],
        most,
    )
    plan.write(journal)
    return plan


def _row_bytes(schema: dict[str, Column]) -> int:
    """Return how many bytes the columns of a segment take."""
    return sum(math.prod(column.row, start=column.dtype.itemsize) for column in schema.values())


def _halving(journal: Journal, first: IntArray, most: int) -> Halving:
    """Halve the scene into leaves of at most so many segments, as a sample shows them."""
    n_prims = int(first[-1])
    n_leaves = n_leaves_for(n_prims, most)
    return Halving.of(_sample(journal, first, n_samples(n_prims, n_leaves)), n_leaves)


def _sample(journal: Journal, first: IntArray, n_wanted: int) -> FloatArray:
    """Return twice the centroids of a sample of all segments, (3, n_wanted)."""
    ids = sampled(int(first[-1]), n_wanted)
    bounds = np.searchsorted(ids, first)
    parts = [np.empty((3, 0), np.float32)]
    for number, (begin, end) in enumerate(pairwise(bounds.tolist())):
        segments = read_stage(journal.chunk(number))[0]["segments"]
        parts.append(centroids_of(segments[ids[begin:end] - first[number]]))
    return np.concatenate(parts, axis=1)


def _batches(sizes: IntArray, n_rows: int) -> IntArray:
    """Return the first chunk of each part: chunks that follow each other and have at most so many rows together."""
    begins, n_here = [0], 0
    for i, size in enumerate(sizes.tolist()):
        if n_here and n_here + size > n_rows:
            begins.append(i)
            n_here = 0
        n_here += size
    return np.array([*begins, len(sizes)], np.int64)


def _shared(schemas: Sequence[dict[str, Column]]) -> dict[str, Column]:
    """Return the columns that all chunks have alike, or that have a value where they are missing; warn of others."""
    found: dict[str, Column] = {}
    left_out: list[str] = []
    for name in dict.fromkeys(name for schema in schemas for name in schema):
        given = [schema[name] for schema in schemas if name in schema]
        column: Column | None = given[0]
        for other in given[1:]:
            column = None if column is None else column.joined(name, other)
        if column is None or (len(given) < len(schemas) and name not in MISSING):
            left_out.append(repr(name.partition("/")[2]))
        else:
            found[name] = column
        if name == "radius" and len(given) < len(schemas):
            warn_caller("some chunks have no radius, and their segments get the radius 0", FileWarning)
    if left_out:
        names = ", ".join(sorted(left_out))
        warn_caller(f"attributes that not all chunks have alike are left out: {names}", FileWarning)
    return found


def _common(facts: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what all chunks say of the lines; else what the first says, and of metadata the offset."""
    first = facts[0] or {"up": None, "unit": None, "metadata": {}}
    for name in ("unit", "up"):
        if any(other[name] != first[name] for other in facts[1:]):
            warn_caller(f"chunks differ in {name}; it is {first[name]!r}, that of the first", FileWarning)
    if any(other["metadata"] != first["metadata"] for other in facts[1:]):
        metadata = first["metadata"]
        return {**first, "metadata": {OFFSET: metadata[OFFSET]} if OFFSET in metadata else {}}
    return first
