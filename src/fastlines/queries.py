"""Queries: what the rays of a batch hit, through a tree or by brute force."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _core
from .arrays import IntArray
from .backend import engine, is_given, kernel_number
from .checks import choice, count
from .errors import InputError
from .forecast import Forecast
from .hits import AllHits, FirstHits
from .layout import Layout
from .lines import Lines, as_lines
from .progress import ProgressCallback, ProgressOption, reporting
from .rays import Rays, check_rays
from .threads import get_num_threads

QueryName: TypeAlias = Literal["first_hit", "any_hit", "count_hits", "all_hits", "next_hits"]

#: The kinds of query, by the name of their method.
QUERIES: tuple[QueryName, ...] = ("first_hit", "any_hit", "count_hits", "all_hits", "next_hits")


@dataclass(frozen=True)
class Question:
    """What rays are asked, as `Tree.first_hit` explains it."""

    query: QueryName
    origins: npt.ArrayLike
    directions: npt.ArrayLike
    radius: npt.ArrayLike
    t_min: npt.ArrayLike = 0.0
    t_max: npt.ArrayLike = np.inf
    at: str = "closest"
    k: int | None = None
    invalid: str = "error"
    progress: ProgressOption = False

    def answer(self, lines: Lines, box: npt.NDArray[Any], ask: Callable[..., Any]) -> Any:
        """Check the question about lines, pass it on as ask(name, rays, *options), and give the answer its shape."""
        choice("at", self.at, ("closest", "surface"))
        if self.query != "next_hits" and self.k is not None:
            raise InputError(f"k={self.k!r} is for query='next_hits', this is {self.query!r}; leave it out")
        k = count("k", self.k, 0) if self.query == "next_hits" else None
        rays = check_rays(self.origins, self.directions, self.radius, self.t_min, self.t_max, self.invalid, box)
        name = "list_hits" if self.query in ("all_hits", "next_hits") else self.query
        surface = self.at == "surface"
        with reporting(self.progress, self.query.replace("_", " ")) as callback:
            if name == "list_hits":
                answer = self._list_hits(rays, surface, k, callback, ask)
            else:
                answer = ask(name, rays, surface, k, callback)
        # Integers come in C's name for 64 bits; NumPy prints its own without a dtype.
        if name == "first_hit":
            t, prim, u, distance = (column.reshape(rays.shape) for column in answer[:4])
            t_out = None if answer[4] is None else answer[4].reshape(rays.shape)
            return FirstHits(t, prim.view(np.int64), u, distance, t_out, rays.skipped, lines)
        if name == "list_hits":
            offsets, (t, prim, u, distance, t_out) = answer
            return AllHits(offsets.view(np.int64), t, prim.view(np.int64), u, distance, t_out, rays.skipped, lines)
        column = answer.reshape(rays.shape)
        return column.view(np.int64) if name == "count_hits" else column

    def _list_hits(
        self, rays: Rays, surface: bool, k: int | None, callback: ProgressCallback | None, ask: Callable[..., Any]
    ) -> Any:
        """Ask for all hits, or the k nearest, unless a sample says that they will not fit into memory."""

        def count_hits(rows: IntArray) -> IntArray:
            counts: IntArray = ask("count_hits", rays.some(rows), surface, None, None)
            return counts if k is None else np.minimum(counts, k)

        forecast = Forecast(len(rays), 24 if surface else 20, count_hits)
        try:
            # Where steps are counted, only those of the question may be.
            return ask("list_hits", rays, surface, k, callback if is_given() else forecast.watch(callback))
        except MemoryError as error:
            why = f": {forecast.refusal}" if forecast.refusal else ""
            fewer = "a smaller k" if self.query == "next_hits" else "next_hits for the nearest"
            raise MemoryError(
                f"the hits of {len(rays)} rays do not fit into memory{why}; ask fewer rays or a smaller radius, "
                f"{fewer}, or count_hits for how many there are"
            ) from error


class Planes(NamedTuple):
    """A KD tree as the core searches it by its planes (cpp/fastlines/query/plane_search.hpp).

    Attributes
    ----------
    nodes : (n, 2) uint32
        An axis and a plane each, or a range of references; siblings stand side by side.
    prims : (n_refs,) uint32
        The primitive of each reference.
    depth : int
        Level of the deepest node.
    corners : tuple of six float
        The root's box.
    """

    nodes: npt.NDArray[np.uint32]
    prims: npt.NDArray[np.uint32]
    depth: int
    corners: tuple[float, ...]


def _is_short(n_rays: int, n_refs: int) -> bool:
    """Whether a batch is over when a second thread has hardly started, unless its rays meet most of the scene."""
    return n_rays <= 256 and n_rays * n_refs <= 10_000_000


def ask_layout(layout: Layout, question: Question, kernel: str) -> Any:
    """Answer by the kernels of the wide layout."""
    number = kernel_number(kernel)
    module = engine()

    def ask(name: str, rays: Rays, surface: bool, k: int | None, progress: Any) -> Any:
        given: dict[str, tuple[Any, ...]] = {"first_hit": (surface,), "list_hits": (surface, k)}
        n_threads = 1 if _is_short(len(rays), len(layout.refs)) else get_num_threads()
        return getattr(module, name)(layout.arrays, rays.arrays(), *given.get(name, ()), number, n_threads, progress)

    return question.answer(layout.lines, layout.box, ask)


def ask_binary(lines: Lines, tree: tuple[Any, ...] | None, box: npt.NDArray[Any], question: Question) -> Any:
    """Answer by a search through the tree as it was built; without a tree, by testing every segment.

    Parameters
    ----------
    lines : Lines
    tree : Planes or tuple of array, optional
        A KD tree as its planes; or nodes and references, which are searched by boxes.
    box : (2, 3) float32
        The bounds of the lines.
    question : Question
    """

    def ask(name: str, rays: Rays, surface: bool, k: int | None, progress: Any) -> Any:
        options = (surface, k) if name == "list_hits" else (surface,)
        segments = lines.segments.reshape(-1, 6)
        return getattr(_core, name)(segments, tree, rays.arrays(), *options, get_num_threads(), progress)

    return question.answer(lines, box, ask)


def brute_force(
    lines: Lines | npt.ArrayLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike,
    *,
    query: QueryName = "all_hits",
    t_min: npt.ArrayLike = 0.0,
    t_max: npt.ArrayLike = np.inf,
    at: str = "closest",
    k: int | None = None,
    invalid: str = "error",
    progress: ProgressOption = False,
) -> Any:
    """Answer a query by testing every segment against every ray: what every tree's answer equals, bit for bit.

    Parameters
    ----------
    lines : Lines or (n, 2, 3) array
    query : {"all_hits", "first_hit", "any_hit", "count_hits", "next_hits"}
    origins, directions, radius, t_min, t_max, at, invalid, progress
        As in `Tree.first_hit`.
    k : int
        As in `Tree.next_hits`; for no other query.

    Returns
    -------
    AllHits, FirstHits or array
        What the method of that name of a `Tree` returns.

    Examples
    --------
    >>> brute_force([[[-1, -1, -1], [1, 1, 1]]], [0, 0, -5], [0, 0, 1], 0.5).prim
    array([0])
    """
    choice("query", query, QUERIES)
    lines = as_lines(lines)
    box = np.array(lines.bounds, np.float32) if len(lines) else np.zeros((2, 3), np.float32)
    question = Question(query, origins, directions, radius, t_min, t_max, at, k, invalid, progress)
    return ask_binary(lines, None, box, question)
