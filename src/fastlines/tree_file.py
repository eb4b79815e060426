"""Trees in files: what a file keeps, and the checks of a file that is read."""

from __future__ import annotations

import dataclasses
import json
import os
import warnings
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from . import container
from .errors import FileFormatError, InputError, InvalidTreeError
from .io import FORMATS
from .lines import Lines
from .settings import Cost, Limits, Presplit, Settings
from .spheres import Spheres
from .splits import split_set_from
from .tree_data import NODE, REF, TreeData

Tree = TypeVar("Tree", bound=TreeData)

FORMAT = "fastlines tree 2"

#: The format of older versions: the same without checksums.
OLD_FORMAT = "fastlines tree 1"

#: The geometry that files keep, by name: classes of `Lines` whose constructor takes no more than that of `Lines`.
KINDS: dict[str, type[Lines]] = {kind.__name__: kind for kind in (Lines, Spheres)}

#: The sections of a file: dtype and the shape of a row.
SECTIONS: dict[str, tuple[str, tuple[int, ...]]] = {
    "strands": ("<i8", ()),
    "nodes": ("<u4", (9,)),
    "refs": ("<u4", (3,)),
    "segments": ("<f4", (2, 3)),
}

#: The errors that are raised where the parts of a file do not make a tree.
UNUSABLE = (KeyError, TypeError, ValueError, AttributeError, OverflowError, RecursionError, InvalidTreeError)

#: The prefixes of the names of sections of attributes: of one value a segment, and of one for each end.
ATTRIBUTE, END_ATTRIBUTE = "attributes/", "end_attributes/"


def write(tree: TreeData, path: str | os.PathLike[str]) -> None:
    """Write a tree and its lines; see `Tree.save`."""
    name = Path(path).name.lower()
    extension = Path(name.removesuffix(".gz")).suffix
    if extension in FORMATS:
        raise InputError(f"{path}: {extension} files hold lines, this is a tree; save it as .flt")
    if name.endswith(".gz"):
        raise InputError(f"{path}: trees are not compressed, so that they can be mapped into memory; save it as .flt")
    if not isinstance(tree.geometry, Lines):
        raise InputError(f"only trees over lines can be saved; this one is over {type(tree.geometry).__name__}")
    if type(tree.geometry) not in KINDS.values():
        raise InputError(
            f"files keep trees over {', '.join(KINDS)}, and this one is over {type(tree.geometry).__name__}; pickle "
            "keeps it, and docs/extending.md explains how to add a class to fastlines.tree_file.KINDS"
        )
    nodes, refs = tree.words()
    lines = tree.geometry
    arrays: dict[str, Any] = {
        "skipped": lines.skipped if len(lines.skipped) else None,
        "strands": lines.strands,
        "nodes": nodes,
        "refs": refs,
        "segments": lines.segments,
        "radius": lines.radius,
        **_attributes(lines, path),
    }
    metadata = {
        "format": FORMAT,
        "method": tree.method,
        "settings": json.dumps(_settings_to_json(tree.settings)),
        "limits_hit": json.dumps(dict(tree.limits_hit)),
        "built_cost": None if tree.built_cost is None else repr(tree.built_cost),
        "kind": None if type(lines) is Lines else type(lines).__name__,
        "up": lines.up,
    }
    # Write larger numbers first, so that each section is aligned for its type.
    kept = [(name, array) for name, array in arrays.items() if array is not None]
    kept.sort(key=lambda item: -item[1].dtype.itemsize)
    container.write(path, dict(kept), {name: text for name, text in metadata.items() if text is not None})


def _attributes(lines: Lines, path: str | os.PathLike[str]) -> dict[str, Any]:
    """Name the sections of the attributes, and warn of those that a file cannot keep."""
    arrays = {f"{END_ATTRIBUTE}{name}": values for name, values in lines.end_attributes.items()}
    arrays |= {
        f"{ATTRIBUTE}{name}": values for name, values in lines.attributes.items() if name not in lines.end_attributes
    }
    little = {name: values.astype(values.dtype.newbyteorder("<"), copy=False) for name, values in arrays.items()}
    kept = {name: values for name, values in little.items() if values.dtype in container.NAMES and values.ndim <= 3}
    lost = [
        f"{name.partition('/')[2]!r} ({values.dtype}, {values.ndim}-d)"
        for name, values in little.items()
        if name not in kept
    ]
    if lost:
        warnings.warn(
            f"{path} does not keep the attributes {', '.join(lost)}: it takes booleans, whole numbers and floats of up "
            "to 8 bytes, in up to 3 dimensions; convert them, or save them beside it",
            stacklevel=4,
        )
    return kept


def read(kind: type[Tree], path: str | os.PathLike[str], verify: bool | None) -> Tree:
    """Map a file into memory and make a checked tree of it; see `fastlines.load`."""
    arrays, metadata = container.read(path, verify)

    def refuse(why: str) -> FileFormatError:
        return FileFormatError(f"{path} is not a usable tree file: {why}; build and save the tree again")

    if metadata.get("format") not in (FORMAT, OLD_FORMAT):
        raise refuse(f"its format is {metadata.get('format')!r}, expected {FORMAT!r} or {OLD_FORMAT!r}")
    if (container.CHECKSUMS in arrays) != (metadata["format"] == FORMAT):
        raise refuse(f"files of format {FORMAT!r} have checksums, others have none")
    for name, (dtype, row) in SECTIONS.items():
        if name not in arrays or arrays[name].ndim == 0 or arrays[name].shape[1:] != row:
            raise refuse(f"the section {name!r} is missing or has another shape")
        if arrays[name].dtype != dtype:
            raise refuse(f"the section {name!r} has another type")
    kind_of_lines = KINDS.get(metadata.get("kind", Lines.__name__))
    if kind_of_lines is None:
        raise refuse(f"it is over {metadata['kind']!r}, expected one of {', '.join(KINDS)}")
    try:
        settings = _settings_from_json(json.loads(metadata["settings"]))
        limits_hit = {str(name): int(n) for name, n in json.loads(metadata["limits_hit"]).items()}
        built_cost = float(metadata["built_cost"]) if "built_cost" in metadata else None
        attributes, end_attributes = (
            {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
            for prefix in (ATTRIBUTE, END_ATTRIBUTE)
        )
        skipped = arrays.get("skipped", np.empty(0, np.int64))
        segments, strands, radius, up = arrays["segments"], arrays["strands"], arrays.get("radius"), metadata.get("up")
        lines = kind_of_lines(segments, strands, radius, attributes, skipped, up, end_attributes)
        nodes, refs = arrays["nodes"].reshape(-1).view(NODE), arrays["refs"].reshape(-1).view(REF)
        return kind(lines, nodes, refs, settings, metadata["method"], limits_hit, built_cost)
    except UNUSABLE as error:
        raise refuse(f"{error}") from None


def has_checksums(path: str | os.PathLike[str]) -> bool:
    """Return whether a tree file holds checksums; those of older versions do not."""
    return container.CHECKSUMS in container.read(path, verify=False)[0]


def _settings_to_json(settings: Settings) -> dict[str, Any]:
    splits = [{"name": split.name, **dataclasses.asdict(split)} for split in settings.splits]
    return dataclasses.asdict(settings) | {"splits": splits}


def _settings_from_json(data: dict[str, Any]) -> Settings:
    parts: dict[str, Any] = {
        "splits": tuple(split_set_from(entry.pop("name"), entry) for entry in data.pop("splits")),
        "cost": Cost(**data.pop("cost")),
        "limits": Limits(**data.pop("limits")),
    }
    if data.get("presplit") is not None:
        parts["presplit"] = Presplit(**data.pop("presplit"))
    return Settings(**parts, **data)
