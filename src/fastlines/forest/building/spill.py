"""Spill: the chunks of a source become files of at most so many rows, which can be read again in any order.

Strands count on from chunk to chunk, as `join_lines` counts them. The places of segments along their strands, and which
strands are closed, are found here, where strands are whole. Small chunks share a file.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...arrays import AnyArray, FloatArray, IntArray, box_of
from ...errors import FileFormatError, FileWarning, InputError
from ...geometry.lines import Lines
from ...geometry.offsets import Offset, offset_of
from ...progress import ProgressCallback, staged
from ...support.atomic_write import sync, sync_folder
from ...support.metadata import to_json
from ...support.texts import counted
from ...support.warn_caller import warn_caller
from .journal import Journal
from .rows import Rows, joined
from .source import Reading, Source
from .stage_file import read_stage, same_rows, write_stage

#: The arrays of a chunk that are no columns.
SKIPPED, CLOSED = ".skipped", ".closed"


@dataclass
class _Before:
    """What comes before a chunk: how many segments, numbers of strands, strands, and rows of the input."""

    prims: int = 0
    numbers: int = 0
    strands: int = 0
    rows: int = 0


@dataclass
class _Pending:
    """What is not yet in a file."""

    parts: list[Rows] = field(default_factory=list)
    skipped: list[IntArray] = field(default_factory=list)
    closed: list[IntArray] = field(default_factory=list)
    before: _Before = field(default_factory=_Before)
    facts: dict[str, Any] = field(default_factory=dict)

    def takes(self, rows: Rows, facts: dict[str, Any], most: int) -> bool:
        """Return whether more rows fit into the same file."""
        if not self.parts:
            return True
        n_rows = sum(map(len, self.parts)) + len(rows)
        return n_rows <= most and rows.schema == self.parts[0].schema and facts == self.facts


class Spill:
    """Writes the chunks of a source into the files of a journal, and compares those that are there."""

    def __init__(self, journal: Journal, how: Reading) -> None:
        self._journal, self._how = journal, how
        self._pending, self._before = _Pending(), _Before()
        self._number = self._n_whole = 0  # of the next file, and of those that a build before has left
        self._offset: Offset | None = None
        self._lost: set[str] = set()

    def run(self, source: Source, progress: ProgressCallback | None) -> None:
        """Write what is missing."""
        if self._journal.spilled.exists():
            return
        first_item = self._go_on()
        for i, item in enumerate(source.items):
            if i < first_item:
                continue
            report = staged(progress, i / len(source.items), (i + 1) / len(source.items))
            offset = self._how.offset if self._how.offset is None or self._offset is None else self._offset
            for lines in item(replace(self._how, offset=offset, progress=report)):
                self._add(lines, i)
            self._flush(i)
        if not self._number:
            self._write(Rows.of(Lines.from_segments(np.empty((0, 2, 3))))[0], 0)
        if self._number < self._n_whole:
            raise self._changed(f"it ends after {counted(self._before.prims, 'segments')}")
        if self._lost:
            warn_caller(
                f"the forest does not keep the attributes {', '.join(sorted(self._lost))}: it takes texts, booleans, "
                "whole numbers and floats of up to 8 bytes, in up to 3 dimensions; convert them",
                FileWarning,
            )
        # From here on, the files are taken to be whole, also after a power failure.
        for number in range(self._number):
            sync(self._journal.chunk(number))
        sync_folder(self._journal.chunk(0).parent)
        totals = {"n_chunks": self._number, "n_numbers": self._before.numbers, "n_strands": self._before.strands}
        write_stage(self._journal.spilled, {}, totals)

    def _go_on(self) -> int:
        """Find the files that are whole, and return the item of the source where reading begins."""
        known: list[dict[str, Any]] = []
        while (path := self._journal.chunk(len(known))).exists():
            try:
                known.append(read_stage(path, verify=True)[1])
            except FileFormatError:  # after a power failure
                break
        self._n_whole = len(known)
        if not known:
            return 0
        self._how = replace(self._how, n_rows=known[0]["n_rows"])  # as the memory was then
        self._offset = offset_of(known[0]["facts"]["metadata"])
        item: int = known[-1]["item"]
        self._number = next(i for i, facts in enumerate(known) if facts["item"] == item)
        self._before = _Before(**known[self._number]["before"])
        return item

    def _add(self, lines: Lines, item: int) -> None:
        """Add a chunk to what is pending, and write the files that are full."""
        self._check_offset(lines)
        before, n_rows = self._before, self._how.n_rows
        facts = {"up": lines.up, "unit": lines.unit, "metadata": json.loads(to_json(lines.metadata))}
        rows, lost = Rows.of(lines)
        self._lost |= set(lost)
        closed, n_strands = np.empty((0, 2), np.int64), 0
        if "strands" in rows.columns:
            rows, closed, n_strands = _on_strands(rows, lines, before.numbers)
        for begin in range(0, max(1, len(rows)), n_rows):
            part = rows.cut(begin, begin + n_rows)
            if not self._pending.takes(part, facts, n_rows):
                self._flush(item)
            if not self._pending.parts:
                self._pending.before = replace(before, prims=before.prims + begin)
                self._pending.facts = facts
            if begin == 0:
                self._pending.skipped.append(lines.skipped + before.rows)
                self._pending.closed.append(closed)
            self._pending.parts.append(part)
        self._before = _Before(
            before.prims + len(lines),
            before.numbers + int(lines.strands.max(initial=-1)) + 1,
            before.strands + n_strands,
            before.rows + len(lines) + len(lines.skipped),
        )

    def _check_offset(self, lines: Lines) -> None:
        """Refuse a chunk with another offset than the first has."""
        if self._offset is None:
            self._offset = lines.offset
        if lines.offset != self._offset:
            raise InputError(
                f"a chunk has the offset {lines.offset}, and those before it {self._offset}; a forest has one for all: "
                f"pass it to build_forest, as offset={list(self._offset)}"
            )

    def _flush(self, item: int) -> None:
        """Write what is pending into a file."""
        pending = self._pending
        if pending.parts:
            parts = [part for part in pending.parts if len(part)] or pending.parts[:1]
            self._write(parts[0] if len(parts) == 1 else joined(parts, parts[0].schema), item)
        self._pending = _Pending()

    def _write(self, rows: Rows, item: int) -> None:
        """Write a file, or compare it with the one that is there."""
        pending, path = self._pending, self._journal.chunk(self._number)
        arrays: dict[str, AnyArray] = {
            **rows.sections(),
            SKIPPED: np.concatenate([*pending.skipped, np.empty(0, np.int64)]),
            CLOSED: np.concatenate([*pending.closed, np.empty((0, 2), np.int64)]),
        }
        if self._number >= self._n_whole:
            corners: FloatArray = rows.columns["segments"].reshape(-1, 3)
            facts = {
                "n_rows": self._how.n_rows,
                "n_prims": len(rows),
                "item": item,
                "box": box_of(corners).tolist() if len(rows) else None,
                "before": vars(pending.before),
                "facts": pending.facts,
            }
            write_stage(path, arrays, facts, durable=False)
        elif not same_rows(path, arrays):
            raise self._changed(f"it differs from segment {pending.before.prims:,} on")
        self._number += 1

    def _changed(self, how: str) -> InputError:
        folder = self._journal.folder
        return InputError(
            f"the source is not the one that the forest {folder} was begun with: {how}; pass the same from its "
            "beginning, or delete the folder to begin anew"
        )


def _on_strands(rows: Rows, lines: Lines, n_before: int) -> tuple[Rows, IntArray, int]:
    """Return rows whose strands count on, with their places; the closed strands, with their sizes; and how many are."""
    strands, segments = lines.strands, lines.segments
    rises = bool((strands[1:] >= strands[:-1]).all())
    order = np.arange(len(strands)) if rises else np.argsort(strands, kind="stable")
    order = order[np.searchsorted(strands, 0, sorter=None if rises else order) :]
    # Now segments are sorted by strand. Find where each strand begins.
    sorted_strands = strands[order]
    begins = np.flatnonzero(np.diff(sorted_strands, prepend=-1))
    sizes = np.diff(np.append(begins, len(order)))
    places = np.full(len(strands), -1, np.int32)
    places[order] = np.arange(len(order)) - np.repeat(begins, sizes)
    first, last = order[begins], order[begins + sizes - 1]
    is_closed = (segments[first, 0] == segments[last, 1]).all(axis=1)
    closed = np.stack([strands[first] + n_before, sizes], axis=1)[is_closed]
    numbered = np.where(strands < 0, -1, strands + n_before)
    return Rows(rows.columns | {"strands": numbered, "places": places}, rows.texts), closed, len(begins)
