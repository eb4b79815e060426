"""What a card says about a geometry or a tree: names and texts, a row each, in a time that suits a notebook."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import TypeAlias

import numpy as np

from ...geometry.any_geometry import AnyGeometry
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
    if geometry.has_parts:
        yield "parts", listed(f"{i}: {part.count_text()}" for i, part in enumerate(geometry.each_part())) or "none"
    else:
        yield geometry.noun, f"{len(geometry):,}"
    if n_strands := geometry.n_strands:
        yield "strands", f"{n_strands:,}"
    unit = geometry.unit
    low, high = geometry.bounds.astype(np.float64)
    if (low <= high).all():
        suffix = f" {shortened(unit)}" if unit else ""
        yield "size", " × ".join(map(number_text, high - low)) + suffix
        yield "box", " to ".join(point_text(corner + geometry.offset) for corner in (low, high))
    if radius := geometry.radius_range:
        yield "radius", range_text(*radius)
    if attributes := geometry.attribute_types():
        yield "attributes", listed(f"{shortened(name)} ({kind})" for name, kind in attributes.items())
    if up := geometry.up:
        yield "up", up
    if n_skipped := geometry.n_skipped:
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
    yield "over", tree.geometry.count_text()
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
