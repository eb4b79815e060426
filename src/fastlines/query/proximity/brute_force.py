"""Brute force: the definition of every answer about points."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias, Unpack

import numpy as np
import numpy.typing as npt

from ... import _core
from ...arrays import choice
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...geometry.collection import as_geometry
from ...geometry.user_primitives import Primitives
from .point_arguments import PointArguments, PointOptions, shows_point_options
from .points import check_points
from .queries import PointQuery, point_backend

PointQueryName: TypeAlias = Literal["nearest", "within", "count_within"]
#: The queries about points, by the names of their methods.
POINT_QUERIES: tuple[PointQueryName, ...] = ("nearest", "within", "count_within")


@shows_point_options
def brute_force_points(
    geometry: AnyGeometry | Primitives | npt.ArrayLike,
    points: npt.ArrayLike,
    radius: npt.ArrayLike | None = None,
    *,
    query: PointQueryName = "nearest",
    k: int | None = None,
    max_distance: npt.ArrayLike | None = None,
    **options: Unpack[PointOptions],
) -> Any:
    """Answer a query about points by testing every primitive; the answer of every tree is the same, bit for bit.

    Parameters
    ----------
    geometry : Lines, Geometry, another container, or (n, 2, 3) array
        As in `build`.
    points, to, ignore, ignore_strands, parts, invalid, progress
        As in `Tree.nearest`.
    radius
        As in `Tree.within`; for "within" and "count_within".
    query : {"nearest", "within", "count_within"}
    k, max_distance
        As in `Tree.nearest`; for "nearest".

    Returns
    -------
    Nearest, Within or array
        What the method of that name of a `Tree` returns.

    Examples
    --------
    >>> brute_force_points([[[-1, 0, 0], [1, 0, 0]], [[-1, 0, 3], [1, 0, 3]]], [0, 0, 1], 2.5, query="within").prim
    array([0, 1])
    """
    choice("query", query, POINT_QUERIES)
    is_nearest = query == "nearest"
    for name, value in (("k", k), ("max_distance", max_distance)):
        if value is not None and not is_nearest:
            raise InputError(f"{name}={value!r} is for query='nearest', this is {query!r}; leave it out")
    if is_nearest == (radius is not None):
        advice = "takes max_distance= instead of radius=" if is_nearest else "needs radius="
        raise InputError(f"query={query!r} {advice}, in the unit of the coordinates")
    if is_nearest:
        given = PointArguments(points, np.inf if max_distance is None else max_distance, "max_distance", **options)
    else:
        given = PointArguments(points, radius, **options)  # type: ignore[arg-type]
    geometry = as_geometry(geometry)
    box = np.array(geometry.tree_bounds, np.float32) if len(geometry) else np.zeros((2, 3), np.float32)
    kind, rows = geometry.core_data()
    view = None if geometry.has_user_code else _core.BinaryView.of_primitives(kind, rows, rows)
    backend = point_backend(geometry, _core, view, is_tree=False)
    asked = PointQuery(backend, check_points(geometry, box, given), geometry, given.progress)
    return asked.nearest(1 if k is None else k) if is_nearest else getattr(asked, query)()
