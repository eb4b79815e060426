"""The answers of a tree and of brute force to a question, as columns, and whether they are the same bit for bit."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np

import fastlines as fl

from ..harness.internals import as_geometry
from .case import Case, Question
from .scenes import Array
from .trees import Subject, on

#: An answer by the names of its columns; of an error, its text, and its class if it is a refusal.
Columns: TypeAlias = dict[str, Any]

RAY_QUERIES = (
    "first_hit",
    "first_surface",
    "any_hit",
    "count_hits",
    "all_hits",
    "iter_all_hits",
    "next_hits",
    "gather",
)
POINT_QUERIES = ("nearest", "within", "count_within")
PAIR_QUERIES = ("pairs", "iter_pairs")
OTHER_QUERIES = (*PAIR_QUERIES, "along", "in_box")
QUERIES = RAY_QUERIES + POINT_QUERIES + OTHER_QUERIES

#: The columns of answers. Of `first_surface`, the others may be those of a piece of a curve.
NAMES = (
    *("offsets", "t", "prim", "u", "distance", "t_out", "part", "skipped", "strand"),
    *("i", "j", "s", "segment", "sum", "squares", "count"),
)
PAIR_COLUMNS = ("i", "j", "s", "t", "distance")
OF_SURFACES = ("t", "prim", "u", "part")
#: The errors by which a query is refused. Any other error is one of the package.
REFUSALS = (fl.FastlinesError, MemoryError)


def columns_of(answer: Any, names: tuple[str, ...] = NAMES) -> Columns:
    """Return the columns of an answer."""
    if isinstance(answer, np.ndarray):
        return {"answer": answer}
    return {name: np.asarray(got) for name in names if (got := getattr(answer, name, None)) is not None}


def error_columns(error: Exception) -> Columns:
    """Return an error as an answer."""
    return {"error": f"{type(error).__name__} ({error})", "refusal": isinstance(error, REFUSALS) and type(error)}


def first_difference(found: Columns, expected: Columns) -> str | None:
    """Describe the first column that differs in shape, type or a bit; None if the answers are the same."""
    sides = {"the tree": found, "brute force": expected}
    if any("error" in answer for answer in sides.values()):
        # The same refusal of both sides is an answer; texts may differ.
        if found.get("refusal") and found.get("refusal") == expected.get("refusal"):
            return None
        return next(f"{side} raises {answer['error']}" for side, answer in sides.items() if "error" in answer)
    if found.keys() != expected.keys():
        return f"the answer has {', '.join(found)}, expected {', '.join(expected)}"
    for name, a in found.items():
        b = expected[name]
        if (a.shape, a.dtype) != (b.shape, b.dtype):
            return f"{name} is {a.dtype} of shape {a.shape}, expected {b.dtype} of shape {b.shape}"
        if a.tobytes() != b.tobytes():
            rows = np.flatnonzero(_words(a) != _words(b))[:3]
            return f"{name} differs at {rows.tolist()}: {a.flat[rows].tolist()}, expected {b.flat[rows].tolist()}"
    return None


def _words(array: Array) -> Array:
    return np.ascontiguousarray(array).reshape(-1).view(f"u{array.itemsize}")


@contextmanager
def _quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def arguments(question: Question, n_prims: int, move: Array | None) -> dict[str, Any]:
    """Return the keywords of a query, its places moved by an offset."""
    given: dict[str, Any] = {**question.rows, **question.options}
    for name in ("origins", "points", "low", "high"):
        if name in given and move is not None:
            given[name] = given[name].astype(np.float64) + move
    if "channels" in given:
        shape = n_prims, given.pop("channels")
        given["values"] = (np.arange(np.prod(shape)) * 7 % 11 / 8 + 0.25).reshape(shape)
    return given


def found_by_tree(subject: Subject, case: Case, question: Question) -> Columns:
    """Return the answer of the tree."""
    move = None if case.offset is None else np.array(case.offset)
    given = arguments(question, subject.n_prims, move)
    if subject.less is not None:
        for name in ("origins", "points", "low", "high"):
            if name in given:
                given[name] = given[name] - np.array(subject.less)
    if question.query in RAY_QUERIES:
        given["kernel"] = question.kernel
    with _quiet(), on(question.simd, question.n_threads):
        try:
            if question.query == "along":
                return columns_of(subject.tree.along(given.pop("points"), **given))
            if question.other is not None:
                other = fl.build(question.other.made(case.offset))
                given["other"] = other.without_offset() if subject.less else other
            answer = getattr(subject.tree, question.query)(**given)
            if question.query == "iter_all_hits":
                return _joined(list(answer), len(question))
            if question.query == "iter_pairs":
                return _joined_pairs(list(answer))
            return columns_of(answer, OF_SURFACES if question.query == "first_surface" else NAMES)
        except Exception as error:
            return error_columns(error)


def _joined(parts: list[Any], n_rays: int) -> Columns:
    """Return the parts of all hits as one answer."""
    each = [columns_of(part) for part in parts]
    counts = np.concatenate([np.diff(one["offsets"]) for one in each] or [np.zeros(n_rays, np.int64)])
    names = [name for name in (each[0] if each else ()) if name not in ("offsets", "skipped")]
    joined = {name: np.concatenate([one[name] for one in each]) for name in names}
    return {"offsets": np.concatenate([[0], np.cumsum(counts)]), **joined}


def _joined_pairs(parts: list[fl.Pairs]) -> Columns:
    """Return the parts of all pairs as one answer."""
    none = fl.brute_force_pairs(np.zeros((0, 2, 3)), 0.0)
    each = [{name: getattr(part, name) for name in PAIR_COLUMNS} for part in (parts or [none])]
    return {name: np.concatenate([one[name] for one in each]) for name in PAIR_COLUMNS}


def left_out(given: dict[str, Any], n_prims: int, n_all: int) -> Any:
    """Return what a query ignores, and all primitives from one on."""
    more = np.arange(n_prims, n_all)
    ignored = np.asarray(given.get("ignore", np.zeros(0, np.int64)))
    return np.concatenate([ignored, np.broadcast_to(more, (*ignored.shape[:-1], len(more)))], axis=-1)


def by_brute_force(subject: Subject, case: Case, question: Question) -> Columns:
    """Return the answer of brute force."""
    geometry = subject.geometry
    move = None if case.offset is None else np.array(case.offset)
    given = arguments(question, len(geometry), move)
    if case.frame is not None:
        given["ignore"] = left_out(given, subject.n_prims, len(geometry))
    with _quiet(), on(None, 1):
        try:
            if question.other is not None:
                given["other"] = as_geometry(question.other.made(case.offset))
            ask: Callable[[Any, str, dict[str, Any]], Columns] = _BY_QUERY.get(question.query, _ray_query)
            return ask(geometry, question.query, given)
        except Exception as error:
            return error_columns(error)


def _ray_query(geometry: Any, query: str, given: dict[str, Any]) -> Columns:
    if query == "first_surface":
        return columns_of(fl.brute_force(geometry, **given, query="first_hit", at="surface"), OF_SURFACES)
    if query == "iter_all_hits":
        given.pop("max_bytes")
        columns = columns_of(fl.brute_force(geometry, **given, query="all_hits"))
        return {name: column for name, column in columns.items() if name != "skipped"}
    return columns_of(fl.brute_force(geometry, **given, query=query))  # type: ignore[arg-type]


def _along(geometry: Any, query: str, given: dict[str, Any]) -> Columns:
    """Pair the segments of the polyline with all primitives, and keep the nearest segment of each primitive."""
    points, radius = given.pop("points"), given.pop("radius")
    needle = fl.Lines.from_segments(np.stack([points[:-1], points[1:]], axis=1), offset=geometry.offset)
    pairs = fl.brute_force_pairs(needle, radius, geometry, **given)
    order = np.lexsort((pairs.i, pairs.distance, pairs.j))
    best = order[np.diff(pairs.j[order], prepend=-1) > 0]
    part, prim = geometry.split(pairs.j[best])
    columns = {"prim": prim, "u": pairs.t[best], "distance": pairs.distance[best]}
    columns |= {} if part is None else {"part": part}
    return columns | {"strand": pairs.strand_j[best], "s": pairs.s[best], "segment": pairs.i[best]}


def _pairs(geometry: Any, query: str, given: dict[str, Any]) -> Columns:
    is_whole = given.pop("max_bytes", None) is None
    return columns_of(fl.brute_force_pairs(geometry, **given), NAMES if is_whole else PAIR_COLUMNS)


_BY_QUERY: dict[str, Any] = {
    **dict.fromkeys(
        POINT_QUERIES, lambda of, query, given: columns_of(fl.brute_force_points(of, **given, query=query))
    ),
    "gather": lambda of, query, given: columns_of(fl.brute_force_gather(of, **given)),
    **dict.fromkeys(PAIR_QUERIES, _pairs),
    "in_box": lambda of, query, given: columns_of(fl.brute_force_in_box(of, **given)),
    "along": _along,
}
