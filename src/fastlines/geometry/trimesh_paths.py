"""Lines from paths of trimesh, which are recognised by their ``entities`` and ``vertices``.

trimesh makes a polyline of an arc or a spline; how many points it has, the argument `scale` of ``entity.discrete``
decides. A chord of a curve with the second derivative C″ is off by |C″|h²/8, where h is the step of the parameter. The
chord over two steps is off by four times that, at the point in its middle. So the points of the polyline themselves
tell how far it is off, and how many more it takes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import AnyArray, kind_of
from ..errors import InputError
from ..support.texts import kinds_text
from .lines import Lines
from .making import FLAT, OF_SIZE, Making, has, with_z

#: What trimesh calls the units that have a short name here.
_UNITS = {
    "kilometers": "km", "meters": "m", "centimeters": "cm", "millimeters": "mm", "microns": "µm", "nanometers": "nm",
    "angstroms": "Å", "inches": "in", "feet": "ft",
}  # fmt: skip

#: The least tolerance, as a fraction of the size of an entity: half of what float32 costs.
_ROUNDING = 2.0**-24

#: So often a polyline is refined, at most; a few times suffice for arcs and Bezier curves.
_MAX_ROUNDS = 16


def of_path(obj: Any, how: Making) -> Lines | None:
    """Return the lines of a Path3D or a Path2D, a strand for each entity; None if the object is none."""
    if has(obj, "geometry", "graph", "dump"):
        raise InputError(
            f"lines are {kind_of(obj)} of trimesh; expected a path: scene.to_geometry() joins the paths of a scene, "
            "each where the scene places it"
        )
    if isinstance(obj, list | tuple) and obj and all(has(part, "entities", "vertices") for part in obj):
        raise InputError(f"lines are {kind_of(obj)} of paths; expected one: trimesh.path.util.concatenate joins them")
    if not has(obj, "entities", "vertices"):
        return None
    vertices = np.asarray(obj.vertices)
    if not len(obj.entities):
        return Lines.from_strands([], **how.options)
    if vertices.ndim != 2 or vertices.shape[1] not in (2, 3):
        raise InputError(f"{kind_of(obj)} has vertices of shape {vertices.shape}; expected (m, 3)")
    for i, entity in enumerate(obj.entities):
        if len(entity.points) and not -1 < min(entity.points) <= max(entity.points) < len(vertices):
            raise InputError(f"{kind_of(obj)}: entity {i} names vertices beyond the {len(vertices)} that there are")
    coarse: Counter[str] = Counter()
    parts = [_polyline(entity, vertices, how.tolerance, coarse) for entity in obj.entities]
    if coarse:
        how.warn(
            f"polylines of entities of {kind_of(obj)} are farther from them than the tolerance: {kinds_text(coarse)}; "
            "give a larger tolerance="
        )
    if no_lines := Counter(type(e).__name__ for e, part in zip(obj.entities, parts, strict=True) if not len(part)):
        how.warn(f"entities of {kind_of(obj)} without a line are not read: {kinds_text(no_lines)}")
    if vertices.shape[1] == 2:
        how.warn(f"{FLAT}; {kind_of(obj)} has a method to_3D, which places its plane in space")
        parts = [with_z(part) if len(part) else part for part in parts]
    values = _values_at_vertices(obj, parts, how)
    made = Lines.from_strands(
        [part.reshape(-1, 3) for part in parts], radius=values.pop("radius", None), attributes=values, **how.options
    )
    unit = getattr(obj, "units", None)
    return replace(made, unit=_UNITS.get(unit, unit)) if isinstance(unit, str) and unit not in ("", "none") else made


def _polyline(entity: Any, vertices: AnyArray, tolerance: float | None, coarse: Counter[str]) -> AnyArray:
    """Return an entity as a polyline within the tolerance; count it in `coarse` if it takes too many points."""
    scale = np.inf
    for _ in range(_MAX_ROUNDS):
        part = np.asarray(entity.discrete(vertices, scale=scale), np.float64)
        if len(part) < 3 or len(part) == len(entity.points):  # a text, or a polyline: all of its points are vertices
            return part
        size = float(np.ptp(part, axis=0).max())
        within = OF_SIZE * size if tolerance is None else max(tolerance, _ROUNDING * size)
        if not (off := _off(part)) > within:
            return part
        if scale == np.inf:
            scale = float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum())  # which makes 20 chords
        scale /= max(1.05 * (off / within) ** 0.5, 1.2)
    coarse[type(entity).__name__] += 1
    return part


def _off(points: AnyArray) -> float:
    """Return how far the chords of a curve are from it: a quarter of what those over two steps are off by."""
    chord, side = points[2:] - points[:-2], points[1:-1] - points[:-2]
    length = (chord * chord).sum(axis=1)
    along = np.divide((side * chord).sum(axis=1), length, out=np.zeros_like(length), where=length > 0)
    return float(np.linalg.norm(side - along[:, None] * chord, axis=1).max()) / 4


def _values_at_vertices(obj: Any, parts: list[AnyArray], how: Making) -> dict[str, AnyArray]:
    """Return the vertex attributes of a path at the points of its entities, if each point is a vertex."""
    given = {str(name): np.asarray(values) for name, values in getattr(obj, "vertex_attributes", {}).items()}
    if not given:
        return {}
    points = [np.asarray(entity.points) for entity in obj.entities]
    if [len(row) for row in points] != [len(part) for part in parts] or any(
        len(values) != len(obj.vertices) for values in given.values()
    ):
        how.warn(
            f"vertex_attributes of {kind_of(obj)} are not read; they are where each has a row for each vertex, and all "
            "points of entities are vertices"
        )
        return {}
    rows = np.concatenate(points)
    return {name: values[rows] for name, values in given.items()}
