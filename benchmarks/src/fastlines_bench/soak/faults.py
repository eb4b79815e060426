"""Faults planted on purpose, one at a time, which a soak must find: in the blocks of layouts, in files, in answers.

A fault replaces a function of the compiled engine, or of the reader of files. Compiled code stays as it is.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from typing import Any, TypeAlias

import numpy as np

import fastlines as fl

from ..harness.internals import container, own, use_engine
from .run import Found, Plan, Progress, Summary, is_decisions, run_case
from .scenes import Array

#: A function in the place of one of the engine, which it gets first.
Changed: TypeAlias = Callable[..., Any]


@dataclass(frozen=True)
class Fault:
    """A planted fault: what it is, where, and the functions of the engine that it replaces."""

    name: str
    where: str
    changed: dict[str, Changed] = field(default_factory=dict)
    #: What changes the arrays and the facts of a file that is read.
    read: Callable[[dict[str, Array], dict[str, str]], None] | None = None
    #: Whether both sides have it, so that it shows beside float64 alone.
    is_of_both: bool = False

    @contextmanager
    def planted(self) -> Iterator[None]:
        """Let the package have the fault."""
        real = container.read
        if self.read is not None:
            change = self.read

            def read(*given: Any, **more: Any) -> Any:
                found, said = real(*given, **more)
                arrays, facts = dict(found), dict(said)
                change(arrays, facts)
                return arrays, facts

            container.read = read
        try:
            with use_engine(_FaultyEngine(self.changed)):
                yield
        finally:
            container.read = real


@dataclass(frozen=True)
class _FaultyEngine:
    """The engine of the instruction set in use, some of whose functions are replaced."""

    changed: dict[str, Changed]

    def __getattr__(self, name: str) -> Any:
        real = getattr(importlib.import_module(f"fastlines._engine_{fl.simd()}"), name)
        return partial(self.changed[name], real) if name in self.changed else real


# ---- Blocks of the layout (cpp/fastlines/layout/wide_blocks.hpp) ----

#: The bytes of a node: its number of children, and the high x planes of these.
N_CHILDREN, HIGH_X = 25, slice(32 + 3 * 16, 32 + 4 * 16)
#: The bytes of a leaf: its number of references, and the largest radius.
N_REFS, RADIUS = slice(24, 26), slice(28, 32)


def _in_blocks(change: Callable[[Array, Array, Array], None]) -> dict[str, Changed]:
    """Change the nodes, leaves and references of each layout that is built."""

    def build_layout(real: Changed, *given: Any) -> Any:
        nodes, leaves, refs, extent = real(*given)
        nodes, leaves, refs = nodes.copy(), leaves.copy(), refs.copy()
        change(nodes, leaves, refs)
        return own(nodes), own(leaves), own(refs), extent

    return {"build_layout": build_layout}


def _drop_reference(nodes: Array, leaves: Array, refs: Array) -> None:
    for leaf in leaves[-1:]:
        n_refs = leaf[N_REFS].view(np.uint16)
        n_refs[n_refs > 1] -= 1


def _shrink_boxes(nodes: Array, leaves: Array, refs: Array) -> None:
    planes = nodes[:, HIGH_X]
    planes[planes > 2] -= 1


def _shrink_radius(nodes: Array, leaves: Array, refs: Array) -> None:
    radius = np.ascontiguousarray(leaves[:, RADIUS]).view(np.float32)
    leaves[:, RADIUS] = np.maximum(radius - 2, 0).view(np.uint8)


def _overlap_pieces(nodes: Array, leaves: Array, refs: Array) -> None:
    refs[:, 1] |= np.uint32(0xFFFF0000)  # s1 of each piece is the end of its line


def _part_pieces(nodes: Array, leaves: Array, refs: Array) -> None:
    low, high = refs[:, 1] & np.uint32(0xFFFF), refs[:, 1] >> np.uint32(16)
    is_cut = (high < 0xFFFF) & (high > low + 64)
    refs[is_cut, 1] -= np.uint32(64 << 16)


def _swap_references(nodes: Array, leaves: Array, refs: Array) -> None:
    if len(refs) > 1:
        refs[[0, -1], 0] = refs[[-1, 0], 0]


def _stale_layout(real: Changed, view: Any, *given: Any) -> Any:
    nodes, leaves, extent = real(view, *given)
    shift = leaves.copy()
    shift[:, :12] = np.roll(leaves[:, :12], 1, axis=0)  # each leaf has the origin of the one before
    return nodes, own(shift), extent


# ---- Files ----


def _swap_rows(arrays: dict[str, Array], facts: dict[str, str]) -> None:
    """Exchange the first and the last row of the primitives."""
    for name in ("segments", "control", "corners"):
        if name in arrays and len(arrays[name]) > 1:
            rows = np.arange(len(arrays[name]))
            rows[[0, -1]] = rows[[-1, 0]]
            arrays[name] = own(np.ascontiguousarray(arrays[name][rows]))


def _lose_frame(arrays: dict[str, Array], facts: dict[str, str]) -> None:
    facts.pop("frame", None)


# ---- Arguments and answers ----


def _smaller_radius(real: Changed, view: Any, rays: Any, at: str, *given: Any) -> Any:
    """Cull with a radius that is too small by a millionth."""
    radius = rays[2] * np.float32(1 - 1e-6) if at == "closest" else rays[2]
    return real(view, (*rays[:2], radius, *rays[3:]), at, *given)


def _end_excluded(real: Changed, view: Any, rays: Any, at: str, *given: Any) -> Any:
    """Take the interval from t_min to t_max without its end."""
    t_max = np.where(np.isfinite(rays[4]), np.nextafter(rays[4], rays[3]), rays[4])
    return real(view, (*rays[:4], t_max, *rays[5:]), at, *given)


def _last_of_ties(real: Changed, *given: Any) -> Any:
    """Order hits of the same t by falling ids."""
    offsets, columns = real(*given)
    ray = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    order = np.lexsort((-columns[1], columns[0], ray))
    return offsets, tuple(None if column is None else np.ascontiguousarray(column[order]) for column in columns)


def _without_ends(real: Changed, *given: Any) -> Any:
    """Miss what is hit at the last point of a line."""
    t, prim, u, distance, t_out = real(*given)
    at_end = u == 1
    missing = ((t, np.inf), (prim, -1), (u, 0), (distance, np.inf))
    return *(np.where(at_end, none, of).astype(of.dtype) for of, none in missing), t_out


def _wrong_last_neighbour(real: Changed, view: Any, points: Any, limit: Any, k: int, *given: Any) -> Any:
    """Return the neighbour after the last one of several in its place."""
    if k < 2:
        return real(view, points, limit, k, *given)
    more = (column.reshape(-1, k + 1) for column in real(view, points, limit, k + 1, *given))
    kept = [*range(k - 1), k]
    return tuple(np.ascontiguousarray(column[:, kept]).reshape(-1) for column in more)


def _without_last_pair(real: Changed, *given: Any) -> Any:
    return tuple(np.ascontiguousarray(column[:-1]) for column in real(*given))


def _larger_distance(real: Changed, *given: Any) -> Any:
    """Return distances that are a hundred-thousandth too large."""
    *rest, distance = real(*given)
    return *rest, distance * np.float32(1 + 1e-5)


def _lost_ray(real: Changed, *given: Any) -> Any:
    """Let the last ray of a query on several threads have no hits."""
    counts = real(*given)
    if given[-2] > 1 and len(counts):
        counts = counts.copy()
        counts[-1] = 0
    return counts


FAULTS = (
    Fault("a leaf has lost a reference", "blocks of a layout", _in_blocks(_drop_reference)),
    Fault("boxes are one quantum too small", "blocks of a layout", _in_blocks(_shrink_boxes)),
    Fault("leaves know too small a radius", "blocks of a layout", _in_blocks(_shrink_radius)),
    Fault("pieces overlap, so hits are doubled", "references of a layout", _in_blocks(_overlap_pieces)),
    Fault("a thousandth between pieces is lost", "references of a layout", _in_blocks(_part_pieces)),
    Fault("two references are exchanged", "references of a layout", _in_blocks(_swap_references)),
    Fault("a refit leaves leaves where they were", "blocks of a refit", {"refit_layout": _stale_layout}),
    Fault("a file has two rows exchanged", "arrays of a file", {}, _swap_rows),
    Fault("a file has lost its frame", "facts of a file", {}, _lose_frame),
    Fault("the radius is a millionth too small", "rays", dict.fromkeys(("any_hit", "count_hits"), _smaller_radius)),
    Fault("t_max is left out", "rays", dict.fromkeys(("first_hit", "count_hits"), _end_excluded)),
    Fault("ties are in the wrong order", "lists of hits", {"list_hits": _last_of_ties}),
    Fault("hits at the end of a line are lost", "first hits", {"first_hit": _without_ends}),
    Fault("the k-th neighbour is wrong", "nearest", {"nearest": _wrong_last_neighbour}),
    Fault("a pair is lost", "pairs", {"pairs": _without_last_pair}),
    Fault(
        "distances of pairs are 1e-5 too large",
        "pairs, brute force too",
        dict.fromkeys(("pairs", "brute_force_pairs"), _larger_distance),
        is_of_both=True,
    ),
    Fault("the last ray of several threads is lost", "counts", {"count_hits": _lost_ray}),
)


@dataclass(frozen=True)
class Trial:
    """How soon a planted fault was found."""

    name: str
    where: str
    is_found: bool
    seconds: float
    n_cases: int
    #: The case that differs, unless both sides have the fault; and what shows it.
    found: Found | None
    shown_by: str


def run_trial(fault: Fault, plan: Plan, progress: Progress, tell: Callable[[str], None]) -> Trial:
    """Soak with a planted fault until it is found, or the time is over."""
    summary, start, share = Summary(plan, most_shrunk=1), time.monotonic(), 0.0
    with fault.planted():
        for number in count():
            if is_decisions(number, plan.choice) == fault.is_of_both:
                run_case(summary, number, tell)
                progress(f"planted: {fault.name}", min(share, 1.0))
            share = (time.monotonic() - start) / (60 * plan.minutes)
            if not summary.is_clean or share > 1:
                break
    found = summary.found[0] if summary.found else None
    seconds = (found.at if found else time.monotonic()) - start
    shown_by = "" if found is None else found.size
    if found is None and not summary.is_clean:
        shown_by = (summary.tally.values.examples or summary.tally.examples)[0]
    return Trial(fault.name, fault.where, not summary.is_clean, seconds, summary.n_cases, found, shown_by)
