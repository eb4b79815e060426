"""Trees in files: what a file keeps, and the checks of a file that is read."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from ..errors import FileFormatError, InputError, InvalidTreeError
from ..io import known_formats
from ..io.reading import check_path
from ..settings.settings import Cost, Limits, Presplit, Settings
from ..settings.splits import split_set_from
from ..support import container
from ..support.metadata import to_json
from ..support.texts import in_one_line
from ..support.warn_caller import warn_caller
from . import layout_file
from .geometry_file import from_sections, to_sections
from .layout import BLOCK, Layout
from .tree_data import NODE, REF, TreeData

Tree = TypeVar("Tree", bound=TreeData)

FORMAT = "fastlines tree 2"

#: What the sections begin with that a file keeps for others than the tree.
MORE = "more/"

#: The sections of nodes and references: the shape of a row of 32-bit words.
SECTIONS: dict[str, tuple[int, ...]] = {"nodes": (9,), "refs": (3,)}

#: The errors that are raised where the parts of a file do not make a tree.
UNUSABLE = (KeyError, TypeError, ValueError, AttributeError, OverflowError, RecursionError, InvalidTreeError)


def write(
    tree: TreeData,
    path: str | os.PathLike[str],
    *,
    layout: bool = False,
    more: Mapping[str, npt.NDArray[Any]] | None = None,
) -> None:
    """Write a tree and its geometry; see `Tree.save`. `more` are arrays that the tree does not read (`read_more`)."""
    name = Path(path).name.lower()
    extension = Path(name.removesuffix(".gz")).suffix
    if extension != ".flt" and extension in known_formats():
        raise InputError(f"{path}: {extension} files hold lines, this is a tree; save it as .flt")
    if name.endswith(".gz"):
        raise InputError(f"{path}: trees are not compressed, so that they can be mapped into memory; save it as .flt")
    sections, facts, lost = to_sections(tree.geometry)
    if lost:
        warn_caller(
            f"{path} does not keep the attributes {', '.join(lost)}: it takes texts, booleans, whole numbers and "
            "floats of up to 8 bytes, in up to 3 dimensions; convert them, or save them beside it"
        )
    nodes, refs = tree.words()
    arrays = {"nodes": nodes, "refs": refs, **sections}
    arrays |= {MORE + name: values for name, values in (more or {}).items()}
    metadata: dict[str, str | None] = {
        "format": FORMAT,
        "method": tree.method,
        "settings": json.dumps(_settings_to_json(tree.settings)),
        "limits_hit": json.dumps(dict(tree.limits_hit)),
        "built_cost": None if tree.built_cost is None else repr(tree.built_cost),
        "kind": None if facts["kind"] == "Lines" else facts["kind"],
        "frame": None if tree.frame is None else json.dumps(tree.frame.tolist()),
        "up": facts.get("up"),
        "unit": facts.get("unit"),
        "tolerance": None if facts.get("tolerance") is None else repr(facts["tolerance"]),
        **{name: to_json(facts[name]) for name in ("metadata", "parts") if facts.get(name)},
    }
    # Write blocks first, then larger numbers first, so that each section is aligned for its type.
    blocks: container.Arrays = {}
    if layout:
        laid_out, facts_of_layout = layout_file.to_sections(cast(Layout, cast(Any, tree).layout))
        metadata |= facts_of_layout
        blocks = {name: array for name, array in laid_out.items() if array.dtype == np.uint8}
        arrays = {**laid_out, **arrays}
    rest = sorted((item for item in arrays.items() if item[0] not in blocks), key=lambda item: -item[1].dtype.itemsize)
    texts = {name: text for name, text in metadata.items() if text is not None}
    container.write(path, blocks | dict(rest), texts, BLOCK if layout else container.ALIGNMENT)


def read_more(path: str | os.PathLike[str]) -> container.Arrays:
    """Map the sections of a file that its tree does not read: see `write`."""
    return more_of(container.read(path, False)[0])


def more_of(arrays: container.Arrays) -> container.Arrays:
    """Return those of the arrays of a file that its tree does not read."""
    return {name.removeprefix(MORE): array for name, array in arrays.items() if name.startswith(MORE)}


def read(
    kind: type[Tree],
    path: str | os.PathLike[str],
    verify: bool | None = None,
    *,
    trusted: bool = False,
    advice: str = container.ADVICE,
) -> Tree:
    """Map a file into memory and make a checked tree of it; see `fastlines.load`.

    A `trusted` file is not checked: this process has read the same file before, and it has not changed since. Errors
    end with the advice.
    """
    if not Path(path).exists():
        check_path(Path(path))
    return from_arrays(kind, path, *container.read(path, verify, advice=advice), trusted=trusted, advice=advice)


def from_arrays(
    kind: type[Tree],
    path: str | os.PathLike[str],
    arrays: container.Arrays,
    metadata: Mapping[str, str],
    *,
    trusted: bool = False,
    advice: str = container.ADVICE,
) -> Tree:
    """Make a tree of the arrays that were read of a file; see `read`."""

    def refuse(why: str) -> FileFormatError:
        return FileFormatError(f"{path} is not a usable tree file: {in_one_line(why)}; {advice}")

    if metadata.get("format") != FORMAT:
        raise refuse(f"its format is {metadata.get('format')!r}, expected {FORMAT!r}")
    for name, row in SECTIONS.items():
        if name not in arrays or arrays[name].ndim == 0 or arrays[name].shape[1:] != row:
            raise refuse(f"the section {name!r} is missing or has another shape")
        if arrays[name].dtype != np.dtype("<u4"):
            raise refuse(f"the section {name!r} has another type")
    try:
        settings = _settings_from_json(json.loads(metadata["settings"]))
        limits_hit = {str(name): int(n) for name, n in json.loads(metadata["limits_hit"]).items()}
        built_cost = float(metadata["built_cost"]) if "built_cost" in metadata else None
        facts: dict[str, Any] = {name: metadata.get(name) for name in ("kind", "up", "unit")}
        facts |= {name: json.loads(metadata[name]) for name in ("tolerance", "metadata", "parts") if name in metadata}
        geometry = from_sections(arrays, facts, refuse, trusted=trusted)
        frame = np.array(json.loads(metadata["frame"]), np.float32) if "frame" in metadata else None
        nodes, refs = arrays["nodes"].reshape(-1).view(NODE), arrays["refs"].reshape(-1).view(REF)
        given = settings, metadata["method"], limits_hit, built_cost
        tree = kind(geometry, nodes, refs, *given, frame=frame, made_by_core=trusted)
        layout = layout_file.from_sections(arrays, metadata, geometry, nodes["box"][0], tree.frame, trusted)
        if layout is not None:
            tree.__dict__["layout"] = layout
        return tree
    except FileFormatError:
        raise
    except UNUSABLE as error:
        raise refuse(f"{error}") from None


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
