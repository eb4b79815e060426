"""Queries: a backend answers checked rays, and its columns become hits."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from .. import _core
from ..arrays import FloatArray, IntArray, choice, count
from ..engines import is_given
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import as_geometry
from ..geometry.user_primitives import Primitives
from ..progress import ProgressOption, reporting
from .backend import Backend, CompiledBackend
from .hits import AllHits, FirstHits
from .ignore import ignored_of
from .memory_check import MemoryCheck
from .rays import AnyRays, RayBatch, check_rays, require_radius, scene_bounds
from .wrappers.wrap import backend_of

#: What the hits of a ray can be ranked by.
RANKS = ("t", "distance")

QueryName: TypeAlias = Literal["first_hit", "any_hit", "count_hits", "all_hits", "next_hits"]

if TYPE_CHECKING:
    pass


#: The queries, by the names of their methods.
QUERIES: tuple[QueryName, ...] = ("first_hit", "any_hit", "count_hits", "all_hits", "next_hits")


def is_surface(at: str) -> bool:
    """Check the option `at`, and return whether t is taken at the surface of the capsule."""
    return choice("at", at, ("closest", "surface")) == "surface"


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


def check_query(
    geometry: AnyGeometry,
    box: FloatArray,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike | None,
    t_min: npt.ArrayLike,
    t_max: npt.ArrayLike,
    invalid: str,
    spread: npt.ArrayLike = 0.0,
    ignore: Any = None,
    ignore_strands: Any = None,
) -> RayBatch:
    """Check rays for geometry in this box; of lines it holds the axes."""
    require_radius(geometry, radius, spread)
    bounds = scene_bounds(geometry, box)
    radius = 0.0 if radius is None else radius
    rays = check_rays(origins, directions, radius, t_min, t_max, invalid, bounds, spread)
    if ignore is None and ignore_strands is None:
        return rays
    return replace(rays, ignored=ignored_of(geometry, rays.shape, ignore, ignore_strands))


def _refuse_surface(rays: AnyRays) -> None:
    if rays.has_spread:
        raise InputError(
            "at='surface' has no meaning with a spread: the reach then grows with the depth of each point of a line, "
            "and no capsule or round cone of one radius has a surface that the ray could enter; leave out at= or "
            "spread="
        )


def first_hit(
    backend: Backend, rays: AnyRays, surface: bool, progress: ProgressOption, geometry: AnyGeometry
) -> FirstHits:
    """Find the nearest hit of each ray."""
    if surface:
        _refuse_surface(rays)
    if not isinstance(rays, RayBatch):
        return cast(FirstHits, rays.first_hit(surface))
    with reporting(progress, "first hit") as callback:
        columns = backend.first_hit(rays, surface, callback)
    return FirstHits.from_columns(columns, rays, geometry)


def any_hit(backend: Backend, rays: AnyRays, progress: ProgressOption) -> npt.NDArray[np.bool_]:
    """Find out for each ray whether it hits anything."""
    if not isinstance(rays, RayBatch):
        return cast(npt.NDArray[np.bool_], rays.any_hit())
    with reporting(progress, "any hit") as callback:
        return backend.any_hit(rays, callback).reshape(rays.shape)


def count_hits(backend: Backend, rays: AnyRays, progress: ProgressOption) -> IntArray:
    """Count the primitives that each ray hits."""
    if not isinstance(rays, RayBatch):
        return cast(IntArray, rays.count_hits())
    with reporting(progress, "count hits") as callback:
        counts = backend.count_hits(rays, callback)
    return counts.reshape(rays.shape).view(np.int64)  # NumPy prints C's name of the type, but not its own


def list_hits(
    backend: Backend,
    rays: AnyRays,
    surface: bool,
    k: int | None,
    progress: ProgressOption,
    geometry: AnyGeometry,
    by_distance: bool = False,
) -> AllHits:
    """List all hits of each ray, or the first k, unless a sample says that they will not fit in memory."""
    if surface:
        _refuse_surface(rays)
    if not isinstance(rays, RayBatch):
        return cast(AllHits, rays.list_hits(surface, k, by_distance))

    def count_some(rows: IntArray) -> IntArray:
        counts = backend.count_hits(rays.some(rows), None)
        return counts if k is None else np.minimum(counts, k)

    memory = MemoryCheck(len(rays), 24 if surface else 20, count_some)
    with reporting(progress, "all hits" if k is None else "next hits") as callback:
        # Without a sample, a module that counts steps counts those of this query alone.
        watched = callback if is_given() else memory.watch(callback)
        try:
            offsets, columns = backend.list_hits(rays, surface, k, by_distance, watched)
        except MemoryError as error:
            why = f": {memory.refusal}" if memory.refusal else ""
            fewer = "next_hits for the nearest" if k is None else "a smaller k"
            raise MemoryError(
                f"the hits of {len(rays)} rays do not fit into memory{why}; trace fewer rays or use a smaller radius, "
                f"{fewer}, or count_hits for how many there are"
            ) from error
    return AllHits.from_columns(offsets, columns, rays, geometry)


def brute_force(
    geometry: AnyGeometry | Primitives | npt.ArrayLike,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    radius: npt.ArrayLike | None = None,
    *,
    query: QueryName = "all_hits",
    spread: npt.ArrayLike = 0.0,
    ignore: Any = None,
    ignore_strands: Any = None,
    t_min: npt.ArrayLike = 0.0,
    t_max: npt.ArrayLike = np.inf,
    at: str = "closest",
    k: int | None = None,
    rank: str = "t",
    merge: str | None = None,
    invalid: str = "error",
    progress: ProgressOption = False,
) -> Any:
    """Answer a query by testing every primitive against every ray; the answer of every tree is the same, bit for bit.

    Parameters
    ----------
    geometry : Lines, Geometry, another container, or (n, 2, 3) array
        As in `build`.
    query : {"all_hits", "first_hit", "any_hit", "count_hits", "next_hits"}
    origins, directions, radius, spread, ignore, ignore_strands, t_min, t_max, at, invalid, progress
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
    choice("query", query, QUERIES)
    surface = is_surface(at)
    if query != "next_hits" and k is not None:
        raise InputError(f"k={k!r} is for query='next_hits', this is {query!r}; leave it out")
    if query == "next_hits" and k is None:
        raise InputError("query='next_hits' needs k=, the number of hits of each ray")
    k = count("k", k, 0) if query == "next_hits" else None
    by_distance = is_by_distance(rank)
    if query != "next_hits" and by_distance:
        raise InputError(f"rank={rank!r} is for query='next_hits', this is {query!r}; leave it out")
    merges = is_merge(merge, at)
    if query != "all_hits" and merges:
        raise InputError(f"merge={merge!r} is for query='all_hits', this is {query!r}; leave it out")
    geometry = as_geometry(geometry)
    box = np.array(geometry.bounds, np.float32) if len(geometry) else np.zeros((2, 3), np.float32)
    rays = check_query(
        geometry, box, origins, directions, radius, t_min, t_max, invalid, spread, ignore, ignore_strands
    )
    data = geometry.spread_data() if rays.has_spread else geometry.core_data()
    core = None if geometry.has_user_code else CompiledBackend(_core, _core.BinaryView.of_primitives(*data))
    backend = backend_of(geometry, core, rays)
    if query == "first_hit":
        return first_hit(backend, rays, surface, progress, geometry)
    if query == "any_hit":
        return any_hit(backend, rays, progress)
    if query == "count_hits":
        return count_hits(backend, rays, progress)
    hits = list_hits(backend, rays, surface, k, progress, geometry, by_distance)
    return hits.merged_by_strand() if merges else hits
