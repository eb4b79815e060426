"""Queries: what the rays of a batch hit, through a tree or by brute force."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _core
from .checks import choice
from .geometry import Lines, as_lines
from .hits import AllHits, FirstHits
from .progress import ProgressOption, reporting
from .rays import check_rays
from .threads import get_num_threads

QueryName: TypeAlias = Literal["first_hit", "any_hit", "count_hits", "all_hits"]

#: The kinds of query, by the name of their method.
QUERIES: tuple[QueryName, ...] = ("first_hit", "any_hit", "count_hits", "all_hits")


def run(
    query: QueryName,
    lines: Lines,
    nodes: npt.NDArray[Any] | None,
    refs: npt.NDArray[Any],
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike,
    *,
    t_min: npt.ArrayLike = 0.0,
    t_max: npt.ArrayLike = np.inf,
    at: str = "closest",
    invalid: str = "error",
    progress: ProgressOption = False,
) -> Any:
    """Answer one of `QUERIES` for a batch of rays; without nodes, by testing every segment."""
    choice("at", at, ("closest", "surface"))
    rays = check_rays(origins, directions, radius, t_min, t_max, invalid, lines.bounds)
    with reporting(progress, query.replace("_", " ")) as callback:
        answer = getattr(_core, query)(
            lines.segments.reshape(-1, 6),
            nodes,
            refs,
            rays.origins,
            rays.directions,
            rays.radius,
            rays.t_min,
            rays.t_max,
            at == "surface",
            get_num_threads(),
            callback,
        )
    # Integers come in C's name for 64 bits; NumPy prints its own without a dtype.
    if query == "first_hit":
        t, prim, u, distance, t_out = (column.reshape(rays.shape) for column in answer)
        return FirstHits(t, prim.view(np.int64), u, distance, t_out if at == "surface" else None, rays.skipped)
    if query == "all_hits":
        offsets, t, prim, u, distance, t_out = answer
        surface = t_out if at == "surface" else None
        return AllHits(offsets.view(np.int64), t, prim.view(np.int64), u, distance, surface, rays.skipped)
    column = answer.reshape(rays.shape)
    return column.view(np.int64) if query == "count_hits" else column


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
    invalid: str = "error",
    progress: ProgressOption = False,
) -> Any:
    """Answer a query by testing every segment against every ray: what every tree's answer equals, bit for bit.

    Parameters
    ----------
    lines : Lines or (n, 2, 3) array
    query : {"all_hits", "first_hit", "any_hit", "count_hits"}
    origins, directions, radius, t_min, t_max, at, invalid, progress
        As in `Tree.first_hit`.

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
    return run(
        query,
        as_lines(lines),
        None,
        np.empty((0, 3), np.uint32),
        origins,
        directions,
        radius,
        t_min=t_min,
        t_max=t_max,
        at=at,
        invalid=invalid,
        progress=progress,
    )
