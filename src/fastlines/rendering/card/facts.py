"""What a card says about a geometry or a tree: names and texts, a row each, in a time that suits a notebook."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import TypeAlias

import numpy as np

from ...geometry.collection import AnyGeometry, Geometry, count_text, parts_of, unit_of, up_of
from ...geometry.curves import Curves
from ...geometry.lines import Lines
from ...geometry.user_primitives import UserPrimitives
from ...settings.settings import Settings, limit_notes
from ...settings.splits import SplitSet
from ...structure.tree_data import TreeData
from ...support.texts import bytes_text, listed, number_text, point_text, range_text, shortened

#: The name of a fact, and what it is.
Fact: TypeAlias = tuple[str, str]

#: The settings that have a row of their own, or that take effect at few nodes.
ELSEWHERE = ("splits", "boxes", "cost", "limits")


def geometry_facts(geometry: AnyGeometry) -> Iterator[Fact]:
    """Yield what is known of a geometry.

    Examples
    --------
    >>> import fastlines as fl
    >>> dict(geometry_facts(fl.Lines.from_segments([[[0, 0, 0], [1, 2, 3]]], radius=0.5)))["radius"]
    '0.5'
    """
    parts = parts_of(geometry)
    with_strands = [part for part in parts if isinstance(part, Lines | Curves)]
    if isinstance(geometry, Geometry):
        yield "parts", listed(f"{i}: {count_text(part)}" for i, part in enumerate(parts)) or "none"
    else:
        yield _kind(geometry), f"{len(geometry):,}"
    if n_strands := sum(part.n_strands for part in with_strands):
        yield "strands", f"{n_strands:,}"
    unit = unit_of(geometry)
    low, high = geometry.bounds.astype(np.float64)
    if (low <= high).all():
        suffix = f" {shortened(unit)}" if unit else ""
        yield "size", " × ".join(map(number_text, high - low)) + suffix
        yield "box", " to ".join(map(point_text, (low, high)))
    if radii := [radius for part in with_strands if (radius := _radius(part)) is not None]:
        yield "radius", range_text(min(low for low, _ in radii), max(high for _, high in radii))
    attributes: dict[str, str] = {}
    for name, kind in (found for part in parts for found in _attributes(part)):
        attributes.setdefault(name, kind)
    if attributes:
        yield "attributes", listed(f"{shortened(name)} ({kind})" for name, kind in attributes.items())
    if up := up_of(geometry):
        yield "up", up
    if n_skipped := sum(len(part.skipped) for part in with_strands):
        yield "left out", f"{n_skipped:,} that held NaN or Inf"


def tree_facts(tree: TreeData) -> Iterator[Fact]:
    """Yield what is known of a tree.

    Examples
    --------
    >>> import fastlines as fl
    >>> dict(tree_facts(fl.build([[[-1, -1, -1], [1, 1, 1]]], "kd-d2")))["method"]
    'kd-d2, a KD tree'
    """
    stats = tree.stats()
    yield "method", f"{stats['method']}, a {'KD tree' if tree.settings.boxes == 'cut' else 'BVH'}"
    if settings := settings_text(tree.settings):
        yield "settings", settings
    custom = isinstance(tree.geometry, UserPrimitives)
    yield "over", f"{len(tree.geometry):,} of your own" if custom else count_text(tree.geometry)
    if stats["n_refs"] != stats["n_prims"]:
        yield "references", f"{stats['n_refs']:,}, {stats['refs_per_prim']:.3g} a primitive"
    yield "nodes", f"{stats['n_nodes']:,}, {stats['n_leaves']:,} of them leaves"
    if stats["n_empty_leaves"]:
        yield "empty leaves", f"{stats['n_empty_leaves']:,}"
    yield "depth", f"{stats['depth']}"
    yield "in a leaf", f"{stats['mean_leaf_refs']:.3g} on average, {stats['largest_leaf_refs']:,} at most"
    model = tree.settings.cost
    yield "cost", f"{stats['cost']:,.6g}, with c_trav {model.c_trav:g} and c_prim {model.c_prim:g}"
    if stats["growth"] != 1:
        yield "growth", f"{stats['growth']:.3g} × the cost before the lines moved"
    yield "memory", memory_text(tree, stats["memory_bytes"])
    if stats["limits_hit"]:
        yield "limits", listed(limit_notes(stats["limits_hit"]))


def settings_text(settings: Settings) -> str:
    """Return the split sets, and the other settings of a search that are not the default.

    Examples
    --------
    >>> import fastlines as fl
    >>> settings_text(fl.METHODS["bvh-d2"])
    'PlaneGrid(8), lookahead (1, 2)'
    """
    said = [_split_text(split) for split in settings.splits]
    for field in fields(settings):
        value = getattr(settings, field.name)
        if field.name not in ELSEWHERE and value != field.default:
            said.append(f"{field.name} {value[0] if isinstance(value, tuple) and len(value) == 1 else value}")
    return ", ".join(said)


def _split_text(split: SplitSet) -> str:
    n_planes = getattr(split, "n_planes", "")
    return f"{type(split).__name__}({n_planes})"


def memory_text(tree: TreeData, n_bytes: int) -> str:
    """Return the memory of a tree, and of its layout if it has been built."""
    layout = tree.__dict__.get("layout")
    wide = "the layout is built on the first query" if layout is None else f"{bytes_text(layout.n_bytes)} as laid out"
    return f"{bytes_text(n_bytes)}; {wide}"


def _kind(geometry: AnyGeometry) -> str:
    if isinstance(geometry, UserPrimitives):
        return "primitives"
    return "segments" if type(geometry) is Lines else type(geometry).__name__.lower()


def _radius(part: Lines | Curves) -> tuple[float, float] | None:
    """Return the least and the largest radius; None without any."""
    if part.radius is None or not len(part):
        return None
    return max(0.0, float(part.radius.min())), part.max_radius


def _attributes(part: AnyGeometry) -> Iterator[tuple[str, str]]:
    """Yield the name of each attribute, and its type with the number of its components."""
    for kind in ("end_attributes", "corner_attributes", "attributes"):
        for name, values in getattr(part, kind, {}).items():
            shape = values.shape[1 + (kind != "attributes") :]
            yield name, str(values.dtype) + "".join(f" × {n}" for n in shape)
