"""Lines from neurons of navis, which are recognised by their attributes: navis is not imported here.

| object                        | recognised by                                          |
|-------------------------------|--------------------------------------------------------|
| ``NeuronList``                | ``neurons``, ``is_mixed``                              |
| ``TreeNeuron``                | ``nodes``, a table with ``parent_id``; ``units``       |
| a list or a tuple of them     | its first member                                       |

A neuron is a tree of nodes, as in a ``.swc`` file. A segment joins a node to its parent, with the radius at both ends.
A root without children is a segment of zero length. A strand is an unbranched section.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, IntArray, kind_of
from ..errors import InputError
from ..support.texts import counted
from ..support.units import unit_of
from .lines import Lines
from .making import Making, has
from .sections import find_sections
from .strand_attributes import array_of

#: The attribute with the position of a neuron in its list.
NEURON = "neuron"


def of_neurons(obj: Any, how: Making) -> Lines | None:
    """Return the lines of a TreeNeuron, or of all neurons of a NeuronList; None if the object is none."""
    if has(obj, "neurons", "is_mixed"):
        return _of_skeletons(list(obj.neurons), how, NEURON)
    if isinstance(obj, list | tuple) and obj and _is_skeleton(obj[0]):
        return _of_skeletons(list(obj), how, NEURON)
    if _is_skeleton(obj):
        return _of_skeletons([obj], how)
    if has(obj, "points", "vect", "to_skeleton"):
        raise InputError("lines are Dotprops, points with directions; dotprops.to_skeleton() makes segments of them")
    return None


def _is_skeleton(obj: Any) -> bool:
    return has(obj, "nodes", "units") and "parent_id" in getattr(obj.nodes, "columns", ())


def _of_skeletons(neurons: list[Any], how: Making, number: str | None = None) -> Lines:
    """Make lines of the nodes of neurons; the attribute `number` has the position of each segment's neuron."""
    for i, neuron in enumerate(neurons):
        if not _is_skeleton(neuron):
            raise InputError(
                f"neuron {i} is {kind_of(neuron)}; expected a TreeNeuron, as read_swc, neuron.skeletonize() of a mesh "
                "and dotprops.to_skeleton() make"
            )
    tables = [neuron.nodes for neuron in neurons]
    counts = np.array([len(table) for table in tables], np.int64)
    first_row = np.cumsum(counts) - counts

    # Join the tables, and make one segment for each node with a parent, and for each root without children.
    ids = _joined([np.asarray(table["node_id"], np.int64) for table in tables])
    parent = _joined([_parents(table, i) + at for i, (table, at) in enumerate(zip(tables, first_row, strict=True))])
    here = np.arange(len(ids))
    has_children = np.zeros(len(ids), np.bool_)
    has_children[parent[parent != here]] = True
    child = np.flatnonzero((parent != here) | ~has_children)
    first, sections, order = find_sections(parent, child)
    ends = np.stack([first, child], axis=1)[order]
    points = [np.stack([np.asarray(table[axis]) for axis in "xyz"], axis=1) for table in tables]
    radius = _radius(tables, how)
    types = _types(tables)
    made = Lines.from_segments(
        np.concatenate([np.empty((0, 3), np.float32), *points])[ends],
        strands=sections,
        radius=None if radius is None else radius[ends],
        attributes={} if number is None else {number: np.repeat(np.arange(len(neurons)), counts)[ends[:, 1]]},
        end_attributes={"id": ids[ends]} | ({} if types is None else {"type": types[ends]}),
        **how.options,
    )
    if n_with := sum(getattr(neuron, "connectors", None) is not None for neuron in neurons):
        how.warn(f"the connectors of {counted(n_with, 'neurons')} are not read")
    return replace(made, unit=_unit(neurons, how))


def _parents(table: Any, i: int) -> IntArray:
    """Return the row of each node's parent; a root is its own."""
    ids, parents = (np.asarray(table[name], np.int64) for name in ("node_id", "parent_id"))
    order = np.argsort(ids, kind="stable")
    if (ids[order][1:] == ids[order][:-1]).any():
        raise InputError(f"neuron {i} has several nodes of one node_id; number them anew before")
    place = np.minimum(np.searchsorted(ids[order], parents), max(len(ids) - 1, 0))
    is_root = parents < 0
    if (missing := ~is_root & (ids[order][place] != parents)).any():
        raise InputError(
            f"neuron {i} has a node whose parent_id, {parents[missing][0]}, is no node; set it to -1 to make it a root"
        )
    return np.where(is_root, np.arange(len(ids)), order[place])


def _radius(tables: list[Any], how: Making) -> npt.NDArray[np.float64] | None:
    """Return the radius of each node; None if none is above 0, as where navis knows of none."""
    radius = _joined([np.asarray(table["radius"], np.float64) for table in tables if "radius" in table])
    if len(radius) != sum(map(len, tables)) or not (radius > 0).any():
        return None
    unknown = ~(radius >= 0)
    if unknown.any():
        how.warn(f"the radii of {counted(int(unknown.sum()), 'nodes')} are NaN or negative, and are taken as 0")
    return np.where(unknown, 0, radius)


def _types(tables: list[Any]) -> AnyArray | None:
    """Return the label of each node, which is the type of a .swc file: whole numbers, or texts."""
    if not tables or not all("label" in table for table in tables):
        return None
    labels = [label for table in tables for label in table["label"].astype(object).tolist()]
    try:
        return np.array([int(label) for label in labels], np.int64)
    except (TypeError, ValueError, OverflowError):
        return array_of([None if label != label else label for label in labels])


def _unit(neurons: list[Any], how: Making) -> str | None:
    """Return the unit of the coordinates, if navis knows of one for all axes."""
    units = {str(neuron.units): neuron.units for neuron in neurons}
    if len(units) > 1:
        how.warn(
            f"neurons differ in their units, {' and '.join(units)}, and coordinates are not scaled; no unit is set"
        )
    if len(units) != 1:
        return None
    (name, unit), *_ = units.items()
    if np.ndim(getattr(unit, "magnitude", 1)):
        how.warn(f"the units of axes differ, {name}, and coordinates are not scaled; no unit is set")
        return None
    try:
        return unit_of(float(unit.to("meter").magnitude))
    except Exception:  # of pint, as of numbers without a dimension
        return None


def _joined(parts: list[Any]) -> Any:
    return np.concatenate([np.empty(0, parts[0].dtype if parts else np.int64), *parts])
