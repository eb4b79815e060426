"""Queries: a backend answers checked rays, and its columns become hits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias, Unpack, cast

import numpy as np
import numpy.typing as npt

from .. import _core
from ..arrays import FloatArray, IntArray, choice, count
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import as_geometry
from ..geometry.offsets import NO_OFFSET
from ..geometry.user_primitives import Primitives
from ..progress import ProgressOption, reporting
from ..support.texts import counted
from .at import At, checked_at, has_exit
from .backend import Backend, CompiledBackend
from .gather import GatherArguments, Gathered, GatherRule, gather_lists
from .hits import AllHits, FirstHits
from .ignore import ignored_of
from .memory_check import MemoryCheck
from .ray_arguments import RayArguments, RayOptions, shows_ray_options
from .rays import AnyRays, RayBatch, check_rays, less_offset, require_radius, scene_bounds, warn_of_radius
from .wrappers.wrap import backend_of

#: What the hits of a ray can be ranked by.
RANKS = ("t", "distance")

QueryName: TypeAlias = Literal["first_hit", "any_hit", "count_hits", "all_hits", "next_hits"]
#: The queries, by the names of their methods.
QUERIES: tuple[QueryName, ...] = ("first_hit", "any_hit", "count_hits", "all_hits", "next_hits")


def is_by_distance(rank: str) -> bool:
    """Check the option `rank`, and return whether hits are ranked by their distance from the ray."""
    return choice("rank", rank, RANKS) == "distance"


def is_merge(merge: str | None, at: str) -> bool:
    """Check the option `merge`, and return whether the hits of a strand are merged."""
    if merge is None:
        return False
    choice("merge", merge, ("strand",))
    if at != "surface":
        raise InputError(f"merge={merge!r} merges intervals in which rays are inside; it needs at='surface'")
    return True


def check_query(geometry: AnyGeometry, box: FloatArray, given: RayArguments) -> RayBatch:
    """Check rays for geometry in this box; of lines it holds the axes. The rays are not yet less the offset."""
    parts = None if given.parts is None else geometry.check_parts(given.parts)
    require_radius(geometry, given.radius, given.spread, parts)
    bounds = scene_bounds(geometry, box)
    rays = check_rays(given if geometry.offset == NO_OFFSET else less_offset(given, geometry.offset, bounds), bounds)
    warn_of_radius(geometry, rays.radius, parts)
    if given.ignore is None and given.ignore_strands is None and parts is None:
        return rays
    ignored = ignored_of(geometry, rays.shape, given.ignore, given.ignore_strands)
    return replace(rays, ignored=ignored, parts=parts)


@dataclass(frozen=True, eq=False)
class Query:
    """Checked rays, and the backend that answers them; rays in the memory of a GPU find their own answers."""

    backend: Backend
    rays: AnyRays
    geometry: AnyGeometry
    progress: ProgressOption = False

    def first_hit(self, at: str = "closest") -> FirstHits:
        """Find the nearest hit of each ray."""
        where = self.checked_at(at)
        if not isinstance(self.rays, RayBatch):
            return cast(FirstHits, self.rays.first_hit(where))
        with reporting(self.progress, "first hit") as callback:
            columns = self.backend.first_hit(self.rays, where, callback)
        return FirstHits.from_columns(columns, self.rays, self.geometry)

    def first_surface(self) -> FirstHits:
        """Find the nearest surface of each ray, without the extent of the hit."""
        if not isinstance(self.rays, RayBatch):
            return self.first_hit("surface")
        return replace(self, rays=replace(self.rays, needs_extent=False)).first_hit("surface")

    def any_hit(self, at: str = "closest") -> npt.NDArray[np.bool_]:
        """Find out for each ray whether it hits anything."""
        where = self.checked_at(at)
        if not isinstance(self.rays, RayBatch):
            return cast(npt.NDArray[np.bool_], self.rays.any_hit(where))
        with reporting(self.progress, "any hit") as callback:
            return self.backend.any_hit(self.rays, where, callback).reshape(self.rays.shape)

    def count_hits(self, at: str = "closest") -> IntArray:
        """Count the primitives that each ray hits."""
        where = self.checked_at(at)
        if not isinstance(self.rays, RayBatch):
            return cast(IntArray, self.rays.count_hits(where))
        with reporting(self.progress, "count hits") as callback:
            counts = self.backend.count_hits(self.rays, where, callback)
        return counts.reshape(self.rays.shape).view(np.int64)  # NumPy prints C's name of the type, but not its own

    def all_hits(self, at: str = "closest", merge: str | None = None) -> AllHits:
        """List all hits of each ray, or those of a strand as one."""
        where, merges = self.checked_at(at), is_merge(merge, at)
        hits = self._list_hits(where, None, False)
        return hits.merged_by_strand() if merges else hits

    def next_hits(self, k: int, at: str = "closest", rank: str = "t") -> AllHits:
        """List the k best hits of each ray."""
        return self._list_hits(self.checked_at(at), count("k", k, 0), is_by_distance(rank))

    def gather(self, given: GatherArguments) -> Gathered:
        """Sum over all hits of each ray."""
        rays, geometry, backend = self.rays, self.geometry, self.backend
        if not isinstance(rays, RayBatch):
            raise InputError("gather sums on the CPU of this process; pass rays as NumPy arrays")
        rule = GatherRule.of(given, geometry, rays)
        with reporting(self.progress, "gather") as callback:
            sums = backend.gather(rays, rule, callback) or gather_lists(backend, geometry, rays, rule, callback)
        return rule.gathered(sums, rays)

    def checked_at(self, at: str) -> At:
        """Check the option `at` for these rays, and return it."""
        where = checked_at(at)
        if has_exit(where) and self.rays.has_spread:
            raise InputError(
                f"at={at!r} has no meaning with a spread: the reach then grows with the depth of each point of a "
                "line, and no capsule or round cone of one radius has a surface that the ray could enter; leave out "
                "at= or spread="
            )
        return where

    def _list_hits(self, at: At, k: int | None, by_distance: bool) -> AllHits:
        """List hits, unless a sample says that they will not fit in memory."""
        backend, rays = self.backend, self.rays
        if not isinstance(rays, RayBatch):
            return cast(AllHits, rays.list_hits(at, k, by_distance))

        def count_some(rows: IntArray) -> IntArray:
            counts = backend.count_hits(rays.some(rows), at, None)
            return counts if k is None else np.minimum(counts, k)

        memory = MemoryCheck(len(rays), 24 if has_exit(at) else 20, count_some, math.inf if k is None else k)
        with reporting(self.progress, "all hits" if k is None else "next hits") as callback:
            watched = memory.watch(callback)
            try:
                offsets, columns = backend.list_hits(rays, at, k, by_distance, watched)
            except MemoryError as error:
                fewer = "next_hits for the nearest" if k is None else "a smaller k"
                raise MemoryError(
                    f"the hits of {counted(len(rays), 'rays')} do not fit into memory{memory.why}; trace fewer rays or "
                    f"use a smaller radius, {fewer}, or count_hits for how many there are"
                ) from error
        return AllHits.from_columns(offsets, columns, rays, self.geometry)


@shows_ray_options
def brute_force(
    geometry: AnyGeometry | Primitives | npt.ArrayLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike | None = None,
    *,
    query: QueryName = "all_hits",
    at: str = "closest",
    k: int | None = None,
    rank: str = "t",
    merge: str | None = None,
    **options: Unpack[RayOptions],
) -> Any:
    """Answer a query by testing every primitive against every ray; the answer of every tree is the same, bit for bit.

    Parameters
    ----------
    geometry : Lines, Geometry, another container, or (n, 2, 3) array
        As in `build`.
    query : {"all_hits", "first_hit", "any_hit", "count_hits", "next_hits"}
    origins, directions, radius, spread, ignore, ignore_strands, parts, t_min, t_max, at, invalid, progress
        As in `Tree.first_hit`.
    k, rank
        As in `Tree.next_hits`; for no other query.
    merge
        As in `Tree.all_hits`; for no other query.

    Returns
    -------
    AllHits, FirstHits or array
        What the method of that name of a `Tree` returns.

    Examples
    --------
    >>> brute_force([[[-1, -1, -1], [1, 1, 1]]], [0, 0, -5], [0, 0, 1], 0.5).prim
    array([0])
    """
    given = RayArguments(origins, directions, radius, **options)
    choice("query", query, QUERIES)
    checked_at(at)
    if query != "next_hits" and k is not None:
        raise InputError(f"k={k!r} is for query='next_hits', this is {query!r}; leave it out")
    if query == "next_hits" and k is None:
        raise InputError("query='next_hits' needs k=, the number of hits of each ray")
    if query != "next_hits" and is_by_distance(rank):
        raise InputError(f"rank={rank!r} is for query='next_hits', this is {query!r}; leave it out")
    if query != "all_hits" and is_merge(merge, at):
        raise InputError(f"merge={merge!r} is for query='all_hits', this is {query!r}; leave it out")
    own: dict[QueryName, dict[str, Any]] = {
        "first_hit": {"at": at},
        "any_hit": {"at": at},
        "count_hits": {"at": at},
        "all_hits": {"at": at, "merge": merge},
        "next_hits": {"k": k, "at": at, "rank": rank},
    }
    return getattr(_brute_force(as_geometry(geometry), given), query)(**own[query])


@shows_ray_options
def brute_force_gather(
    geometry: AnyGeometry | Primitives | npt.ArrayLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike | None = None,
    values: npt.ArrayLike | None = None,
    *,
    blur: str = "box",
    sigma: npt.ArrayLike = 0.0,
    line_sigma: npt.ArrayLike = 0.0,
    optical_depth: npt.ArrayLike | None = None,
    phase: float | None = None,
    inner: bool = True,
    squares: bool = False,
    **options: Unpack[RayOptions],
) -> Gathered:
    """Sum over all hits of each ray, which tests every primitive; `Tree.gather` of every tree returns the same bits.

    Parameters
    ----------
    geometry : Lines, Geometry, another container, or (n, 2, 3) array
        As in `build`.
    origins, directions, radius, values, blur, sigma, line_sigma, optical_depth, phase, inner, squares
        As in `Tree.gather`, like the other options.

    Examples
    --------
    >>> print(brute_force_gather([[[-1, -1, -1], [1, 1, 1]]], [0, 0, -5], [0, 0, 1], 0.5, blur="none").sum)
    1.0
    """
    what = GatherArguments(values, blur, sigma, line_sigma, optical_depth, phase, inner, squares)
    given = RayArguments(origins, directions, radius, **options)
    return _brute_force(as_geometry(geometry), given).gather(what)


def _brute_force(geometry: AnyGeometry, given: RayArguments) -> Query:
    """Check rays for a search that tests every primitive."""
    box = np.array(geometry.tree_bounds, np.float32) if len(geometry) else np.zeros((2, 3), np.float32)
    rays = check_query(geometry, box, given)
    kind, rows = geometry.spread_data() if rays.has_spread else geometry.core_data()
    seen = rows if rays.parts is None else geometry.seen_data(rays.parts)[1]
    view = None if geometry.has_user_code else _core.BinaryView.of_primitives(kind, seen, rows)
    core = None if view is None else CompiledBackend(_core, view)
    return Query(backend_of(geometry, core, view, rays, is_tree=False), rays, geometry, given.progress)
