"""Queries: a backend answers checked rays, and its columns become hits."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _core
from .arrays import IntArray, choice, count
from .backend import Backend, CompiledBackend, is_given
from .errors import InputError
from .forecast import Forecast
from .hits import AllHits, FirstHits
from .lines import Lines, as_lines
from .meshes import core_data
from .progress import ProgressOption, reporting
from .rays import RayBatch, check_rays

QueryName: TypeAlias = Literal["first_hit", "any_hit", "count_hits", "all_hits", "next_hits"]

#: The queries, by the names of their methods.
QUERIES: tuple[QueryName, ...] = ("first_hit", "any_hit", "count_hits", "all_hits", "next_hits")


def is_surface(at: str) -> bool:
    """Check the option `at`, and return whether t is taken at the surface of the capsule."""
    return choice("at", at, ("closest", "surface")) == "surface"


def first_hit(backend: Backend, rays: RayBatch, surface: bool, progress: ProgressOption, lines: Lines) -> FirstHits:
    """Find the nearest hit of each ray."""
    with reporting(progress, "first hit") as callback:
        columns = backend.first_hit(rays, surface, callback)
    return FirstHits.from_columns(columns, rays.shape, rays.skipped, lines)


def any_hit(backend: Backend, rays: RayBatch, progress: ProgressOption) -> npt.NDArray[np.bool_]:
    """Find out for each ray whether it hits anything."""
    with reporting(progress, "any hit") as callback:
        return backend.any_hit(rays, callback).reshape(rays.shape)


def count_hits(backend: Backend, rays: RayBatch, progress: ProgressOption) -> IntArray:
    """Count the segments that each ray hits."""
    with reporting(progress, "count hits") as callback:
        counts = backend.count_hits(rays, callback)
    return counts.reshape(rays.shape).view(np.int64)  # NumPy prints C's name of the type, but not its own


def list_hits(
    backend: Backend, rays: RayBatch, surface: bool, k: int | None, progress: ProgressOption, lines: Lines
) -> AllHits:
    """List all hits of each ray, or its k nearest, unless a sample says that they will not fit in memory."""

    def count_some(rows: IntArray) -> IntArray:
        counts = backend.count_hits(rays.some(rows), None)
        return counts if k is None else np.minimum(counts, k)

    forecast = Forecast(len(rays), 24 if surface else 20, count_some)
    with reporting(progress, "all hits" if k is None else "next hits") as callback:
        # Without a sample, a module that counts steps counts those of this query alone.
        watched = callback if is_given() else forecast.watch(callback)
        try:
            offsets, columns = backend.list_hits(rays, surface, k, watched)
        except MemoryError as error:
            why = f": {forecast.refusal}" if forecast.refusal else ""
            fewer = "next_hits for the nearest" if k is None else "a smaller k"
            raise MemoryError(
                f"the hits of {len(rays)} rays do not fit into memory{why}; trace fewer rays or use a smaller radius, "
                f"{fewer}, or count_hits for how many there are"
            ) from error
    return AllHits.from_columns(offsets, columns, rays.skipped, lines)


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
    """Answer a query by testing every segment against every ray; the answer of every tree is the same, bit for bit.

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
    surface = is_surface(at)
    if query != "next_hits" and k is not None:
        raise InputError(f"k={k!r} is for query='next_hits', this is {query!r}; leave it out")
    k = count("k", k, 0) if query == "next_hits" else None
    lines = as_lines(lines)
    box = np.array(lines.bounds, np.float32) if len(lines) else np.zeros((2, 3), np.float32)
    rays = check_rays(origins, directions, radius, t_min, t_max, invalid, box)
    backend = CompiledBackend(_core, _core.BinaryView.of_primitives(*core_data(lines)))
    if query == "first_hit":
        return first_hit(backend, rays, surface, progress, lines)
    if query == "any_hit":
        return any_hit(backend, rays, progress)
    if query == "count_hits":
        return count_hits(backend, rays, progress)
    return list_hits(backend, rays, surface, k, progress, lines)
