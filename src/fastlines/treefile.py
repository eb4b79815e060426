"""Trees in files: what is kept, and what is checked before a query may rely on it."""

from __future__ import annotations

import dataclasses
import json
import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from . import container
from .errors import FileFormatError, InputError, InvalidTreeError
from .geometry import FloatArray, Lines
from .io import FORMATS
from .settings import Cost, Limits, Presplit, Settings
from .splits import SplitSet
from .structure import NODE, REF, TreeStructure

FORMAT = "fastlines tree 1"

#: So many references are looked at at a time, which bounds the memory that a check takes.
BLOCK = 1 << 14

#: The sections of a file: dtype and the shape of a row.
SECTIONS: dict[str, tuple[str, tuple[int, ...]]] = {
    "strands": ("<i8", ()),
    "nodes": ("<u4", (9,)),
    "refs": ("<u4", (3,)),
    "segments": ("<f4", (2, 3)),
}


#: What the names of the sections of attributes begin with.
ATTRIBUTE = "attributes/"


def write(tree: TreeStructure, path: str | os.PathLike[str]) -> None:
    """Write a tree and its lines; see `Tree.save`."""
    name = Path(path).name.lower()
    extension = Path(name.removesuffix(".gz")).suffix
    if extension in FORMATS:
        raise InputError(f"{path}: {extension} files hold lines, this is a tree; save it as .flt")
    if name.endswith(".gz"):
        raise InputError(f"{path}: trees are not compressed, so that they can be mapped into memory; save it as .flt")
    if not isinstance(tree.geometry, Lines):
        raise InputError(f"only trees over lines can be saved; this one is over {type(tree.geometry).__name__}")
    nodes, refs = tree.words()
    arrays: dict[str, Any] = {
        "strands": tree.geometry.strands,
        "nodes": nodes,
        "refs": refs,
        "segments": tree.geometry.segments,
    }
    if len(tree.geometry.skipped):
        arrays = {"skipped": tree.geometry.skipped, **arrays}
    if tree.geometry.radius is not None:
        arrays["radius"] = tree.geometry.radius
    arrays |= _attributes(tree.geometry, path)
    metadata = {
        "format": FORMAT,
        "method": tree.method,
        "settings": json.dumps(_settings_to_json(tree.settings)),
        "limits_hit": json.dumps(dict(tree.limits_hit)),
    }
    if tree.built_cost is not None:
        metadata["built_cost"] = repr(tree.built_cost)
    if tree.geometry.up is not None:
        metadata["up"] = tree.geometry.up
    # Larger numbers come first, so that each section is aligned for its type.
    container.write(path, dict(sorted(arrays.items(), key=lambda item: -item[1].dtype.itemsize)), metadata)


def _attributes(lines: Lines, path: str | os.PathLike[str]) -> dict[str, Any]:
    """Name the sections of the attributes, and warn of those that a file can not keep."""
    little = {
        name: values.astype(values.dtype.newbyteorder("<"), copy=False) for name, values in lines.attributes.items()
    }
    kept = {name: values for name, values in little.items() if values.dtype in container.NAMES and values.ndim <= 3}
    lost = [f"{name!r} ({values.dtype}, {values.ndim}-d)" for name, values in little.items() if name not in kept]
    if lost:
        warnings.warn(
            f"{path} does not keep the attributes {', '.join(lost)}: it takes booleans, whole numbers and floats of up "
            "to 8 bytes, in up to 3 dimensions; convert them, or save them beside it",
            stacklevel=4,
        )
    return {f"{ATTRIBUTE}{name}": values for name, values in kept.items()}


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
        built_cost = float(metadata["built_cost"]) if "built_cost" in metadata else None
        skipped = arrays.get("skipped", np.empty(0, np.int64))
        attributes = {
            name.removeprefix(ATTRIBUTE): array for name, array in arrays.items() if name.startswith(ATTRIBUTE)
        }
        lines = Lines(
            arrays["segments"], arrays["strands"], arrays.get("radius"), attributes, skipped, metadata.get("up")
        )
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
        raise refuse(f"{error}") from None
    fields: dict[str, Any] = {
        "geometry": lines,
        "nodes": arrays["nodes"].reshape(-1).view(NODE),
        "refs": arrays["refs"].reshape(-1).view(REF),
        "settings": settings,
        "method": method,
        "limits_hit": limits_hit,
        "built_cost": built_cost,
    }
    try:
        tree = TreeStructure(**fields)
    except (InputError, InvalidTreeError) as error:
        raise refuse(f"{error}") from None
    _check_usable(tree, refuse)
    return fields


def _check_usable(tree: TreeStructure, refuse: Callable[[str], FileFormatError]) -> None:
    """Check what a query relies on beyond what every tree is checked for, in time about proportional to the file."""
    nodes, leaf = tree.nodes, tree.is_leaf
    inner = np.flatnonzero(~leaf)
    left, right = inner + 1, nodes["right"][inner].astype(np.int64)
    parents = np.bincount(np.concatenate([left, right]), minlength=tree.n_nodes)
    if parents[0] != 0 or (parents[1:] != 1).any():
        raise refuse("a node does not have one parent")
    first, n_refs = nodes["first_ref"].astype(np.int64), nodes["n_refs"].astype(np.int64)
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
    if not ((tree.refs["s0"] >= 0) & (tree.refs["s0"] <= tree.refs["s1"])).all():
        raise refuse("a reference is not a piece of its segment")
    if not _tile(tree):
        raise refuse("the pieces of a segment do not tile it")
    if not _in_leaves(tree, tree.geometry.segments):
        raise refuse("a piece of a segment does not lie in its leaf's box")


def _tile(tree: TreeStructure) -> bool:
    """Whether each s of each segment is in exactly one piece: then all hits are told once.

    The number of pieces that hold s is how many begin at s or before, less how many end there. So only where pieces
    begin and where they end need to be put in order: a segment's begin at 0, and where another ends; the last at inf.
    """
    if tree.n_refs == 0:
        return tree.n_prims == 0
    prim = tree.refs["prim"].astype(np.uint64) << np.uint64(32)
    # The bits of floats that are not negative are in the order of the floats.
    begins, ends = (np.sort(prim | tree.refs[end].view(np.uint32)) for end in ("s0", "s1"))
    last = np.append(np.diff(begins >> np.uint64(32)) > 0, True)
    is_first = np.roll(last, 1)
    whole = np.arange(tree.n_prims, dtype=np.uint64) << np.uint64(32)
    return (
        np.array_equal(begins[is_first], whole)
        and np.array_equal(ends[last], whole | np.float32(np.inf).view(np.uint32))
        and np.array_equal(begins[~is_first], ends[~last])
    )


def _in_leaves(tree: TreeStructure, segments: FloatArray) -> bool:
    """Whether both ends of each piece lie in its leaf's box, but for the rounding of cuts."""
    leaves = np.flatnonzero(tree.is_leaf)
    leaf_of = np.repeat(leaves, tree.nodes["n_refs"][leaves])
    slack = np.ldexp(float(np.abs(segments).max(initial=0)), -21) + 2 * np.finfo(np.float32).smallest_subnormal
    for start in range(0, tree.n_refs, BLOCK):
        refs = tree.refs[start : start + BLOCK]
        box = tree.nodes["box"][leaf_of[start : start + BLOCK]]
        p, q = segments[refs["prim"]].astype(np.float64).swapaxes(0, 1)
        for s in (refs["s0"], np.minimum(refs["s1"], 1)):
            at = p + s[:, None] * (q - p)
            if (at < box[:, 0] - slack).any() or (at > box[:, 1] + slack).any():
                return False
    return True


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
    if data.get("presplit") is not None:
        parts["presplit"] = Presplit(**data.pop("presplit"))
    return Settings(**parts, **data)
