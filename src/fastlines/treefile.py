"""Trees in files: what is kept, and what is checked before a query may rely on it."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Callable
from typing import Any

import numpy as np

from . import container
from .errors import FileFormatError, InputError
from .geometry import Lines
from .settings import Cost, Limits, Settings, SplitSet
from .structure import NODE, REF, TreeStructure

FORMAT = "fastlines tree 1"

#: The sections of a file: dtype and the shape of a row.
SECTIONS: dict[str, tuple[str, tuple[int, ...]]] = {
    "strands": ("<i8", ()),
    "nodes": ("<u4", (9,)),
    "refs": ("<u4", (3,)),
    "segments": ("<f4", (2, 3)),
}


def write(tree: TreeStructure, path: str | os.PathLike[str]) -> None:
    """Write a tree and its lines; see `Tree.save`."""
    if not isinstance(tree.geometry, Lines):
        raise InputError(f"only trees over lines can be saved; this one is over {type(tree.geometry).__name__}")
    nodes, refs = tree.words()
    # The section of eight-byte numbers comes first, so that each is aligned for its type.
    arrays: dict[str, Any] = {
        "strands": tree.geometry.strands,
        "nodes": nodes,
        "refs": refs,
        "segments": tree.geometry.segments,
    }
    if tree.geometry.radius is not None:
        arrays["radius"] = tree.geometry.radius
    metadata = {
        "format": FORMAT,
        "method": tree.method,
        "settings": json.dumps(_settings_to_json(tree.settings)),
        "limits_hit": json.dumps(dict(tree.limits_hit)),
    }
    container.write(path, arrays, metadata)


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Map a file into memory and check it; returns the fields of the tree. See `fastlines.load`."""
    arrays, metadata = container.read(path)

    def refuse(why: str) -> FileFormatError:
        return FileFormatError(f"{path} is not a usable tree file: {why}; build and save the tree again")

    if metadata.get("format") != FORMAT:
        raise refuse(f"its format is {metadata.get('format')!r}, expected {FORMAT!r}")
    for name, (dtype, row) in SECTIONS.items():
        if name not in arrays or arrays[name].ndim == 0 or arrays[name].shape[1:] != row:
            raise refuse(f"the section {name!r} is missing or has another shape")
        if arrays[name].dtype != dtype:
            raise refuse(f"the section {name!r} has another type")
    try:
        settings = _settings_from_json(json.loads(metadata["settings"]))
        limits_hit = {str(name): int(n) for name, n in json.loads(metadata["limits_hit"]).items()}
        method = metadata["method"]
        lines = Lines.from_segments(arrays["segments"], strands=arrays["strands"], radius=arrays.get("radius"))
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
        raise refuse(f"{error}") from None
    fields: dict[str, Any] = {
        "geometry": lines,
        "nodes": arrays["nodes"].reshape(-1).view(NODE),
        "refs": arrays["refs"].reshape(-1).view(REF),
        "settings": settings,
        "method": method,
        "limits_hit": limits_hit,
    }
    _check_usable(TreeStructure(**fields), refuse)
    return fields


def _check_usable(tree: TreeStructure, refuse: Callable[[str], FileFormatError]) -> None:
    """Check what a query relies on, in time proportional to the file."""
    nodes, refs, leaf = tree.nodes, tree.refs, tree.is_leaf
    index = np.arange(tree.n_nodes)
    if tree.n_nodes == 0:
        raise refuse("it has no nodes")
    inner = index[~leaf]
    left, right = inner + 1, nodes["right"][inner].astype(np.int64)
    if (right <= left).any() or (right >= tree.n_nodes).any():
        raise refuse("a child does not follow its parent")
    parents = np.bincount(np.concatenate([left, right]), minlength=tree.n_nodes)
    if parents[0] != 0 or (parents[1:] != 1).any():
        raise refuse("a node does not have one parent")
    first, n_refs = nodes["first_ref"].astype(np.int64), nodes["n_refs"].astype(np.int64)
    if (first + n_refs > tree.n_refs).any():
        raise refuse("a node's references reach past the end")
    if n_refs[leaf].sum() != tree.n_refs or (np.cumsum(n_refs[leaf]) - n_refs[leaf] != first[leaf]).any():
        raise refuse("the leaves do not list each reference once")
    low, high = nodes["box"][:, 0], nodes["box"][:, 1]
    if not (np.isfinite(nodes["box"]).all() and (low <= high).all()):
        raise refuse("a box is not a box")
    if any((low[inner] > low[child]).any() or (high[inner] < high[child]).any() for child in (left, right)):
        raise refuse("a child's box does not lie in its parent's")
    assert isinstance(tree.geometry, Lines)
    if tree.n_prims and (nodes["box"][0] != tree.geometry.bounds).any():
        raise refuse("the root's box does not bound the segments")
    if tree.n_refs and (refs["prim"] >= tree.n_prims).any():
        raise refuse("a reference names no segment")
    if len(np.unique(refs["prim"])) != tree.n_prims:
        raise refuse("a segment is in no leaf")
    if not ((refs["s0"] >= 0) & (refs["s0"] <= refs["s1"])).all():
        raise refuse("a reference is not a piece of its segment")


def _settings_to_json(settings: Settings) -> dict[str, Any]:
    data = dataclasses.asdict(settings)
    data["splits"] = [{"name": split.name, **dataclasses.asdict(split)} for split in settings.splits]
    return data


def _settings_from_json(data: dict[str, Any]) -> Settings:
    sets: dict[str, type[SplitSet]] = {kind.name: kind for kind in SplitSet.__subclasses__()}
    parts: dict[str, Any] = {
        "splits": tuple(sets[entry.pop("name")](**entry) for entry in data.pop("splits")),
        "cost": Cost(**data.pop("cost")),
        "limits": Limits(**data.pop("limits")),
    }
    return Settings(**parts, **data)
