"""Lines from paths of trimesh, which are recognised by their ``entities`` and ``vertices``."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import AnyArray, kind_of
from ..errors import InputError
from ..support.texts import kinds_text
from .lines import Lines
from .making import FLAT, Making, has, with_z

#: What trimesh calls the units that have a short name here.
_UNITS = {
    "kilometers": "km", "meters": "m", "centimeters": "cm", "millimeters": "mm", "microns": "µm", "nanometers": "nm",
    "angstroms": "Å", "inches": "in", "feet": "ft",
}  # fmt: skip


def of_path(obj: Any, how: Making) -> Lines | None:
    """Return the lines of a Path3D or a Path2D, a strand for each entity; None if the object is none."""
    if has(obj, "geometry", "graph", "dump"):
        raise InputError(
            f"lines are a {type(obj).__name__} of trimesh; expected a path of it, as in scene.geometry[name]"
        )
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
    scale = obj.scale  # which trimesh computes each time
    parts = [np.asarray(entity.discrete(vertices, scale=scale)) for entity in obj.entities]
    if no_lines := Counter(type(e).__name__ for e, part in zip(obj.entities, parts, strict=True) if not len(part)):
        how.warn(f"entities of {kind_of(obj)} without a line are not read: {kinds_text(no_lines)}")
    if vertices.shape[1] == 2:
        how.warn(FLAT)
        parts = [with_z(part) if len(part) else part for part in parts]
    values = _values_at_vertices(obj, parts, how)
    made = Lines.from_strands(
        [part.reshape(-1, 3) for part in parts], radius=values.pop("radius", None), attributes=values, **how.options
    )
    unit = getattr(obj, "units", None)
    return replace(made, unit=_UNITS.get(unit, unit)) if isinstance(unit, str) and unit else made


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
