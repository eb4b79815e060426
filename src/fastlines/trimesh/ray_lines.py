"""`RayLines`: what ``mesh.ray`` of trimesh is for the triangles of a mesh, for the lines of a path.

The methods are those of ``trimesh.ray.ray_pyembree.RayMeshIntersector``, with the same names, arguments and answers.
trimesh is not imported: its paths are recognised by their attributes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from inspect import Parameter, signature
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, count, did_you_mean, kind_of, to_float32
from ..builder import build
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.foreign import lines as as_lines
from ..geometry.making import has
from ..tree import Tree

Float64Array = npt.NDArray[np.float64]


class RayLines:
    """Ray queries on lines, as ``mesh.ray`` has them for triangles.

    Lines are tubes with round ends: their own radius, and that of the query, make them thick. A hit is where a ray
    enters such a tube, or the origin of a ray that begins inside. Each segment of a line is hit once by a ray.

    Parameters
    ----------
    lines : trimesh.path.Path3D, Tree, Curves, or what `fastlines.lines` takes
        A path is read again, and a tree built over it, when a query finds that its vertices or entities have changed.
    radius : number or (n,) array, optional
        How near a ray must pass, in units of the coordinates, for all rays or for each. It is required unless the lines
        have a radius of their own, to which it is added; each method takes another one.
    tolerance, offset, invalid
        As in `fastlines.lines`, each time that the path is read. Arcs and splines of a path become polylines that are
        within `tolerance` of them, by default 10⁻⁵ of the size of each. With ``offset="auto"``, coordinates far from
        zero keep their digits; rays and locations are in the coordinates of the path all the same.

    Raises
    ------
    InputError
        If `lines` are no lines, or another argument cannot be used. For a mesh, trimesh has ``mesh.ray``.

    Notes
    -----
    All methods take ``radius=`` and the options of `Tree.first_hit`, such as ``t_max=``, ``ignore=`` and
    ``invalid="skip"``; where all hits are listed, ``merge="strand"``, too. With ``at="closest"``, locations are the
    points of rays that are nearest to the lines.

    Each call compares the whole path with the one that was read. For many small calls on a path that stays as it is,
    keep ``tree = rays.tree``, and query that.

    Examples
    --------
    >>> from fastlines.trimesh import RayLines
    >>> wires = RayLines([[[0, 0, 0], [4, 0, 0]], [[0, 0, 3], [2, 0, 3], [4, 0, 3]]], radius=0.5)
    >>> locations, index_ray, index_line = wires.intersects_location([[1, 0, -5], [3, 9, 0]], [[0, 0, 1], [0, -1, 0]])
    >>> print(locations, index_ray, index_line)
    [[ 1.   0.  -0.5]
     [ 1.   0.   2.5]
     [ 3.   0.5  0. ]] [0 0 1] [0 1 0]
    >>> wires.index_entity[index_line]
    array([0, 1, 0])
    """

    def __init__(
        self,
        lines: Any,
        radius: npt.ArrayLike | None = None,
        *,
        tolerance: float | None = None,
        offset: Any = None,
        invalid: str = "error",
    ) -> None:
        if has(lines, "faces", "ray"):
            raise InputError(
                f"lines are {kind_of(lines)}, a surface of triangles; trimesh queries it itself, by mesh.ray, and "
                "mesh.vertices[mesh.edges_unique] are its edges as lines"
            )
        self._given = lines
        self._options = {"tolerance": tolerance, "offset": offset, "invalid": invalid}
        self._hash = self._path_hash()
        self._tree = _tree_of(lines, self._options)
        self.radius = _checked_radius(radius)

    @property
    def tree(self) -> Tree:
        """The tree over the lines, with all queries of fastlines."""
        if (now := self._path_hash()) != self._hash:
            self._hash, self._tree = now, _tree_of(self._given, self._options)
        return self._tree

    @property
    def lines(self) -> AnyGeometry:
        """The lines as fastlines holds them, in float32; `index_line` counts their segments."""
        return self.tree.geometry

    @property
    def index_entity(self) -> IntArray:
        """The entity of the path that each segment is part of, (n_segments,) int64.

        Of other lines, it is the strand; -1 is none. ``index_entity[index_line]`` needs hits: -1 of a miss would name
        the last one.
        """
        strands: IntArray = self.lines.strands  # type: ignore[attr-defined]
        return strands

    def intersects_location(
        self,
        ray_origins: npt.ArrayLike,
        ray_directions: npt.ArrayLike,
        multiple_hits: bool = True,
        *,
        radius: npt.ArrayLike | None = None,
        **options: Any,
    ) -> tuple[Float64Array, IntArray, IntArray]:
        """Return where rays hit lines.

        Parameters
        ----------
        ray_origins, ray_directions : (n, 3) array
            Directions need not have length 1.
        multiple_hits : bool
            Whether to return every hit of each ray, or the first alone. A radius is given by its name.

        Returns
        -------
        locations : (h, 3) float64
            The points on the rays, those of a ray by rising distance.
        index_ray : (h,) int64
            The ray of each hit, rising.
        index_line : (h,) int64
            The segment of each hit, a row of `lines`.
        """
        index_line, index_ray, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits, return_locations=True, radius=radius, **options
        )
        return locations, index_ray, index_line

    def intersects_id(
        self,
        ray_origins: npt.ArrayLike,
        ray_directions: npt.ArrayLike,
        multiple_hits: bool = True,
        max_hits: int | None = None,
        return_locations: bool = False,
        *,
        radius: npt.ArrayLike | None = None,
        **options: Any,
    ) -> Any:
        """Return which lines rays hit; `intersects_location` explains the other parameters.

        Parameters
        ----------
        max_hits : int, optional
            How many hits of each ray to return at most, the nearest ones; by default all.
        return_locations : bool
            Whether to return `locations`, too.

        Returns
        -------
        index_line, index_ray : (h,) int64
        locations : (h, 3) float64
            If `return_locations`.

        Examples
        --------
        >>> wires = RayLines([[[0, 0, z], [4, 0, z]] for z in range(3)], radius=0.1)
        >>> wires.intersects_id([[1, 0, -5]], [[0, 0, 1]])
        (array([0, 1, 2]), array([0, 0, 0]))
        >>> wires.intersects_id([[1, 0, -5]], [[0, 0, 1]], max_hits=2)
        (array([0, 1]), array([0, 0]))
        """
        for name, flag in (("multiple_hits", multiple_hits), ("return_locations", return_locations)):
            if not isinstance(flag, bool | np.bool_):
                raise InputError(f"{name}={flag!r}; expected True or False; a radius is given as radius=")
        most = None if max_hits is None else count("max_hits", max_hits, 0)
        lists_all = bool(multiple_hits) and most is None
        _check_options("intersects_id", Tree.all_hits if lists_all else Tree.next_hits, options)
        tree, given = self._query(ray_origins, ray_directions, radius, options)
        if lists_all:
            hits = tree.all_hits(*given, **options)
        else:
            k = most if multiple_hits else 1 if most is None else min(most, 1)
            hits = tree.next_hits(*given, k, **options)
        return (hits.prim, hits.ray, hits.points()) if return_locations else (hits.prim, hits.ray)

    def intersects_first(
        self,
        ray_origins: npt.ArrayLike,
        ray_directions: npt.ArrayLike,
        *,
        radius: npt.ArrayLike | None = None,
        **options: Any,
    ) -> IntArray:
        """Return the first line that each ray hits, (n,) int64; -1 for a miss.

        Examples
        --------
        >>> wires = RayLines([[[0, 0, 0], [4, 0, 0]]])
        >>> wires.intersects_first([[1, 0, -5], [9, 9, 9]], [[0, 0, 1], [0, 0, 1]], radius=0.1)
        array([ 0, -1])
        """
        _check_options("intersects_first", Tree.first_hit, options)
        tree, given = self._query(ray_origins, ray_directions, radius, options)
        return tree.first_hit(*given, **options).prim

    def intersects_any(
        self,
        ray_origins: npt.ArrayLike,
        ray_directions: npt.ArrayLike,
        *,
        radius: npt.ArrayLike | None = None,
        **options: Any,
    ) -> npt.NDArray[np.bool_]:
        """Return whether each ray hits any line, (n,) bool.

        Examples
        --------
        >>> RayLines([[[0, 0, 0], [4, 0, 0]]], radius=0.1).intersects_any([[1, 0, -5], [9, 9, 9]], [[0, 0, 1]])
        array([ True, False])
        """
        _check_options("intersects_any", Tree.any_hit, options)
        tree, given = self._query(ray_origins, ray_directions, radius, options)
        found: npt.NDArray[np.bool_] = tree.any_hit(*given, **options)
        return found

    def __repr__(self) -> str:
        return f"<RayLines: {self.lines!r}>"

    def _path_hash(self) -> int | None:
        """Return what trimesh knows a state of a path by; None for lines that do not change."""
        return hash(self._given) if has(self._given, "entities", "vertices") else None

    def _query(
        self, ray_origins: npt.ArrayLike, ray_directions: npt.ArrayLike, radius: Any, options: dict[str, Any]
    ) -> tuple[Tree, tuple[Any, Any, Any]]:
        """Return the tree, and the rays as lists with their radius; `options` get the default of `at`."""
        origins, directions = (
            _as_list(rays, name) for rays, name in ((ray_origins, "ray_origins"), (ray_directions, "ray_directions"))
        )
        options.setdefault("at", "surface")
        return self.tree, (origins, directions, self.radius if radius is None else radius)


def _check_options(name: str, query: Callable[..., Any], options: dict[str, Any]) -> None:
    """Refuse options that the query of a tree does not have, in the name of a method."""
    known = _options_of(query)
    for option in options:
        if option not in known:
            raise TypeError(f"{name} has no option {option!r} here{did_you_mean(option, known)}")


@cache
def _options_of(query: Callable[..., Any]) -> tuple[str, ...]:
    """Return the options of a query that are given by name alone."""
    return tuple(name for name, one in signature(query).parameters.items() if one.kind is Parameter.KEYWORD_ONLY)


def _checked_radius(radius: npt.ArrayLike | None) -> npt.ArrayLike | None:
    """Check a radius, or those of several rays."""
    if radius is None:
        return None
    values = to_float32(radius, "radius")
    if values.ndim > 1 or not (values >= 0).all() or not np.isfinite(values).all():
        raise InputError(f"radius={radius!r}; expected a number from 0, or one for each ray")
    return radius


def _as_list(rays: npt.ArrayLike, name: str) -> Any:
    """Return origins or directions as (n, 3), one for each ray or for all."""
    shape = to_float32(rays, name).shape
    if shape == (0,) or (len(shape) == 2 and shape[1] == 3):
        return rays
    hint = ": a single ray is [[x, y, z]]" if shape == (3,) else ": .reshape(-1, 3)" if shape[-1:] == (3,) else ""
    raise InputError(f"{name} have shape {shape}; expected (n, 3), x y z of each ray{hint}")


def _tree_of(lines: Any, options: dict[str, Any]) -> Tree:
    """Return a tree over lines, or the tree that was given; `options` are those of `fastlines.lines`."""
    tree = lines if has(lines, "geometry", "first_hit") else None
    is_made = tree is not None or (isinstance(lines, AnyGeometry) and not has(lines, "segments", "strands"))
    given = [
        name for name, value in options.items() if value is not None and not (name == "invalid" and value == "error")
    ]
    if is_made and given:
        raise InputError(
            f"{given[0]}= is for lines that are read here, and lines are {kind_of(lines)}; give it where that is made"
        )
    if tree is None:
        tree = build(lines if is_made else as_lines(lines, **options))
    if not tree.geometry.has_directions or tree.geometry.has_parts:
        raise InputError(
            f"lines are a tree over {type(tree.geometry).__name__}; expected one over lines or curves; the methods of "
            "the tree itself answer for others"
        )
    return tree
