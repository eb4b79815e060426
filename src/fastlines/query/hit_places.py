"""Points, outward normals, tangents and attributes where rays hit primitives: one hit a row, in float64."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, did_you_mean
from ..errors import InputError
from ..geometry.boxes import Boxes
from ..geometry.collection import AnyGeometry, Geometry, in_parts, parts_of
from ..geometry.curves import Curves
from ..geometry.lines import Lines
from ..geometry.triangles import Triangles, triangle_weights
from ..geometry.user_primitives import UserPrimitives
from ..support.vectors import dot, is_zero

Float64Array = npt.NDArray[np.float64]


class HitPlaces(NamedTuple):
    """Hits and their rays: one row for each hit, without misses."""

    prim: IntArray
    u: Float64Array
    t: Float64Array
    origins: Float64Array
    directions: Float64Array
    radius: Float64Array
    #: Whether the ray enters a surface at t. It does not if it starts inside, so that t is a bound of the ray.
    enters: npt.NDArray[np.bool_]

    @classmethod
    def without_rays(cls, prim: IntArray, u: Float64Array) -> HitPlaces:
        """Return hits whose rays are unknown (NaN)."""
        unknown = np.full(len(prim), np.nan)
        vectors = np.full((len(prim), 3), np.nan)
        return cls(prim, u, unknown, vectors, vectors, unknown, np.zeros(len(prim), bool))

    def some(self, rows: Any) -> HitPlaces:
        """Return the hits in some rows."""
        return HitPlaces(*(column[rows] for column in self))

    def on_rays(self) -> Float64Array:
        """Return the points on the rays."""
        return np.asarray(self.origins + self.t[:, None] * self.directions)


def _of_parts(
    geometry: Geometry, hits: HitPlaces, ask: Callable[[Any, HitPlaces], npt.NDArray[Any]]
) -> npt.NDArray[np.float64]:
    """Evaluate a function of a part and its hits for each part of a geometry, and join the results."""
    part, prim = in_parts(geometry, hits.prim)
    asked = [(rows, ask(geometry.parts[i], hits._replace(prim=prim).some(rows))) for i, rows in _rows_of(part)]
    shape = asked[0][1].shape[1:] if asked else (3,)
    found = np.full((len(part), *shape), np.nan)
    for rows, values in asked:
        found[rows] = values
    return found


def _rows_of(part: IntArray) -> list[tuple[int, IntArray]]:
    return [(int(i), np.flatnonzero(part == i)) for i in np.unique(part)]


def has_axes(geometry: AnyGeometry) -> bool:
    """Return whether hits may be at a closest approach to an axis, not at a surface."""
    return any(isinstance(part, Lines | Curves) for part in parts_of(geometry))


def points(geometry: AnyGeometry, hits: HitPlaces) -> Float64Array:
    """Return the point of each hit on its ray; where the ray enters a surface, t is computed again in float64."""
    if isinstance(geometry, Geometry):
        return _of_parts(geometry, hits, points)
    if isinstance(geometry, Curves):
        return points(geometry.pieces.lines, _on_pieces(geometry, hits))
    if isinstance(geometry, Lines):
        return _on_axes(geometry, hits)[0]
    if isinstance(geometry, UserPrimitives):
        return hits.on_rays()
    if isinstance(geometry, Triangles):
        t = _cross_triangles(geometry, hits)
    else:
        t = _enter_boxes(geometry, hits).max(axis=1)
    return hits._replace(t=np.where(hits.enters & np.isfinite(t), t, hits.t)).on_rays()


def outwards(geometry: AnyGeometry, hits: HitPlaces) -> Float64Array:
    """Return the outward unit normal at each hit."""
    if isinstance(geometry, Geometry):
        return _of_parts(geometry, hits, outwards)
    if isinstance(geometry, Curves):
        return outwards(geometry.pieces.lines, _on_pieces(geometry, hits))
    if isinstance(geometry, UserPrimitives):
        if not callable(normals := getattr(geometry.source, "normals", None)):
            raise InputError(f"{type(geometry.source).__name__} has no method normals(ids, points); add it for normals")
        return np.asarray(normals(hits.prim, hits.on_rays()), np.float64)
    if isinstance(geometry, Lines):
        at, s = _on_axes(geometry, hits)
        start, edge = _axes(geometry, hits.prim)
        away = at - (start + s[:, None] * edge)
    elif isinstance(geometry, Triangles):
        corners = geometry.corners[hits.prim].astype(np.float64)
        away = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        away[dot(away, hits.directions) > 0] *= -1
    else:
        # Take the face of the plane that the ray crosses last on its way in.
        rows, axis = np.arange(len(hits.prim)), _enter_boxes(geometry, hits).argmax(axis=1)
        away = np.zeros((len(rows), 3))
        away[rows, axis] = -np.sign(hits.directions[rows, axis])
    centred = is_zero(away)
    away[centred] = -hits.directions[centred]
    return unit(away)


def tangents(geometry: AnyGeometry, hits: HitPlaces) -> Float64Array:
    """Return the unit vector along the line or curve at each hit; NaN for what has none."""
    if isinstance(geometry, Geometry):
        return _of_parts(geometry, hits, tangents)
    if isinstance(geometry, Curves):
        return unit(geometry.evaluate(hits.prim, hits.u).tangents)
    if isinstance(geometry, Lines):
        return unit(_axes(geometry, hits.prim)[1])
    return np.full((len(hits.prim), 3), np.nan)


def own_radius(geometry: AnyGeometry, prim: IntArray) -> Float64Array:
    """Return the largest radius of each primitive; 0 for those without."""
    if isinstance(geometry, Geometry):
        part, prim = in_parts(geometry, prim)
        found = np.zeros(len(prim))
        for i, rows in _rows_of(part):
            found[rows] = own_radius(geometry.parts[i], prim[rows])
        return found
    if isinstance(geometry, Curves) and geometry.radius is not None:
        return np.asarray(geometry.radius[prim].max(axis=1, initial=0.0), np.float64)
    if isinstance(geometry, Lines):
        return np.asarray(geometry.end_radii[prim].max(axis=1, initial=0.0), np.float64)
    return np.zeros(len(prim))


def sample(geometry: AnyGeometry, name: str, hits: HitPlaces) -> npt.NDArray[Any]:
    """Return an attribute at each hit, interpolated where there are values for ends or corners."""
    if not isinstance(geometry, Geometry):
        known = names(geometry)
        if name not in known:
            raise InputError(f"name={name!r} is not an attribute of {geometry!r}{did_you_mean(name, known)}")
        return _sample(geometry, name, hits)
    if not any(name in names(part) for part in geometry.parts):
        known = dict.fromkeys(known for part in geometry.parts for known in names(part))
        raise InputError(f"name={name!r} is not an attribute of any part{did_you_mean(name, known)}")
    part, prim = in_parts(geometry, hits.prim)
    hits = hits._replace(prim=prim)
    asked = [
        (rows, _sample(geometry.parts[i], name, hits.some(rows)))
        for i, rows in _rows_of(part)
        if name in names(geometry.parts[i])
    ]
    shapes = {_row_shape(part, name) for part in geometry.parts if name in names(part)}
    if len(shapes) > 1:
        raise InputError(f"{name!r} has different shapes in the parts, {', '.join(map(str, sorted(shapes)))}")
    found = np.full((len(part), *shapes.pop()), np.nan)
    for rows, values in asked:
        found[rows] = values
    return found


def has_corner_values(geometry: AnyGeometry, name: str) -> bool:
    """Return whether an attribute has values at corners, which are interpolated at the point of a hit."""
    meshes = [part for part in parts_of(geometry) if isinstance(part, Triangles | Boxes)]
    return any(name in mesh.corner_attributes for mesh in meshes)


def _row_shape(part: AnyGeometry, name: str) -> tuple[int, ...]:
    """Return the shape of one value of an attribute."""
    if isinstance(part, Triangles | Boxes):
        at_places: Mapping[str, npt.NDArray[Any]] = part.corner_attributes
    else:
        assert isinstance(part, Lines | Curves)
        at_places = part.end_attributes
        if name == "radius" and name not in at_places and part.radius is not None:
            return ()
    return at_places[name].shape[2:] if name in at_places else part.attributes[name].shape[1:]


def names(geometry: AnyGeometry) -> Mapping[str, None]:
    """Return the names of what `sample` knows."""
    if isinstance(geometry, Triangles | Boxes):
        return dict.fromkeys([*geometry.corner_attributes, *geometry.attributes])
    if isinstance(geometry, Lines | Curves):
        radius = ["radius"] if geometry.radius is not None else []
        return dict.fromkeys([*geometry.end_attributes, *radius, *geometry.attributes])
    return {}


def _sample(geometry: AnyGeometry, name: str, hits: HitPlaces) -> npt.NDArray[Any]:
    if isinstance(geometry, Triangles | Boxes):
        if name not in geometry.corner_attributes:
            return _numbers(name, geometry.attributes[name])[hits.prim]
        values = _numbers(name, geometry.corner_attributes[name])[hits.prim]
        weights = triangle_weights(geometry.corners[hits.prim].astype(np.float64), hits.on_rays())
    else:
        assert isinstance(geometry, Lines | Curves)
        if name == "radius" and name not in geometry.end_attributes and geometry.radius is not None:
            if isinstance(geometry, Curves):
                return geometry.evaluate(hits.prim, hits.u).radius
            ends = geometry.end_radii
        elif name not in geometry.end_attributes:
            return _numbers(name, geometry.attributes[name])[hits.prim]
        else:
            ends = _numbers(name, geometry.end_attributes[name])
        values, weights = ends[hits.prim], np.stack([1 - hits.u, hits.u], axis=1)
    if values.dtype.kind != "f":
        last = weights.shape[1] - 1
        return np.asarray(values[np.arange(len(values)), last - weights[:, ::-1].argmax(axis=1)])
    return np.asarray((weights.reshape(*weights.shape, *[1] * (values.ndim - 2)) * values).sum(axis=1))


def _numbers(name: str, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if values.dtype.kind not in "fiub":
        raise InputError(
            f"{name!r} holds {values.dtype}, expected numbers; index the attribute with hits.prim[hits.hit]"
        )
    return values


def _cross_triangles(triangles: Triangles, hits: HitPlaces) -> Float64Array:
    """Return the t at which rays cross the planes of triangles; not finite where they are parallel."""
    corners = triangles.corners[hits.prim].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        above, facing = (dot(normal, x) for x in (corners[:, 0] - hits.origins, hits.directions))
        t = above / facing
    # If the ray is nearly parallel to the triangle, its plane does not determine t.
    length = np.sqrt(dot(normal, normal) * dot(hits.directions, hits.directions))
    return np.where(np.abs(facing) > 1e-3 * length, t, np.nan)


def _enter_boxes(boxes: Boxes, hits: HitPlaces) -> Float64Array:
    """Return the t at which rays come in between each pair of planes of boxes, (n, 3); −inf where they are parallel."""
    low, high = np.moveaxis(boxes.corners[hits.prim].astype(np.float64), 1, 0)
    plane = np.where(hits.directions > 0, low, high)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (plane - hits.origins) / hits.directions
    parallel = np.abs(hits.directions) < 1e-6 * np.sqrt(dot(hits.directions, hits.directions))[:, None]
    return np.where(parallel, -np.inf, t)


def _on_pieces(curves: Curves, hits: HitPlaces) -> HitPlaces:
    piece, s = curves.locate(hits.prim, hits.u)
    return hits._replace(prim=piece, u=s)


def _axes(lines: Lines, prim: IntArray) -> tuple[Float64Array, Float64Array]:
    """Return the start of each segment that was hit, and its end − start."""
    ends = lines.segments[prim].astype(np.float64)
    return ends[:, 0], ends[:, 1] - ends[:, 0]


def _on_axes(lines: Lines, hits: HitPlaces) -> tuple[Float64Array, Float64Array]:
    """Return the point of each hit on a line, and its place on the axis."""
    # Intersect the surface in float64, except where a bound of the ray cut it off.
    start, edge = _axes(lines, hits.prim)
    radii = lines.end_radii[hits.prim].astype(np.float64) + hits.radius[:, None]
    exact, at = enter_round_cones(start, edge, radii[:, 0], radii[:, 1] - radii[:, 0], hits.origins, hits.directions)
    use = hits.enters & np.isfinite(exact)
    return hits._replace(t=np.where(use, exact, hits.t)).on_rays(), np.where(use, at, hits.u)


def unit(vectors: Float64Array) -> Float64Array:
    """Return unit vectors; NaN for those of length zero."""
    with np.errstate(invalid="ignore"):
        return np.asarray(vectors / np.sqrt(dot(vectors, vectors))[..., None] + 0.0)  # no negative zeros


def enter_round_cones(
    start: Float64Array,
    edge: Float64Array,
    radius0: Float64Array,
    slope: Float64Array,
    origins: Float64Array,
    directions: Float64Array,
) -> tuple[Float64Array, Float64Array]:
    """Find where lines enter round cones, which they hit, one ray and one round cone a row.

    The formulas are those of cpp/fastlines/primitives/round_cone_test.hpp.

    Parameters
    ----------
    start, edge : (n, 3)
        The start of the axis, and its end − start.
    radius0, slope : (n,)
        The radius at the start, and how much larger it is at the end.
    origins, directions : (n, 3)

    Returns
    -------
    t, s : (n,)
        In units of the direction's length; and the place on the axis of the ball that the line touches there. NaN if
        rounding makes the line miss.

    Examples
    --------
    >>> start, edge = np.array([[0.0, 0, 0]]), np.array([[4.0, 0, 0]])
    >>> origins, directions = np.array([[2.0, 0, -5]]), np.array([[0.0, 0, 2]])
    >>> t, s = enter_round_cones(start, edge, np.ones(1), np.zeros(1), origins, directions)
    >>> print(t, s)
    [2.] [0.5]
    """
    length = np.sqrt(dot(directions, directions))
    ray = directions / length[:, None]
    # Measure depths from the point of the line that is nearest to the middle of the axis, so that nothing cancels.
    shift = dot(start + 0.5 * edge - origins, ray)
    offset = start - origins - shift[:, None] * ray
    p_r, e_r = dot(offset, ray), dot(edge, ray)
    a, b = offset - p_r[:, None] * ray, edge - e_r[:, None] * ray
    ab, b2, e2 = dot(a, b), dot(b, b), dot(edge, edge)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Q(s) = c0 + 2·c1·s + c2·s², the squared half chord in the ball at s.
        c0, c1, c2 = radius0**2 - dot(a, a), radius0 * slope - ab, slope**2 - b2
        k = np.sqrt((c1**2 - c0 * c2) / (e2 - slope**2))
        w = e_r * k
        s = np.where(w * c1 > 0, (c1**2 - e_r**2 * c0) / ((e2 - slope**2) * (w + c1)), (w - c1) / c2)
        half_chord = np.sqrt(np.stack([c0 + s * (2 * c1 + s * c2), c0, c0 + 2 * c1 + c2]))
    t = p_r + np.stack([s * e_r, 0 * e_r, e_r]) - half_chord
    on_side = (s >= 0) & (s <= 1) & (e2 > slope**2) & np.isfinite(t[0])
    at_end = np.where(np.isnan(t[1]) | (t[2] < t[1]), 1.0, 0.0)
    found = np.where(on_side, s, at_end)
    depth = np.where(on_side, t[0], np.fmin(t[1], t[2]))
    return (depth + shift) / length, found
