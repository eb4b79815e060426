"""The files of tiles: how they are named, written, and known to a manifest."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..builder import build
from ..geometry.any_geometry import AnyGeometry
from ..structure import tree_file
from ..support import container
from ..tree import Tree
from .manifest import Manifest, TileFacts
from .verified_files import set_verified


def tile_name(number: int) -> str:
    """Return the name of the file of a tile, as `build_forest` writes it."""
    return f"{number:05d}.flt"


def next_name(file: str) -> str:
    """Return the name of the file of a tile that is built again.

    Examples
    --------
    >>> next_name("00003.flt"), next_name("00003.1.flt")
    ('00003.1.flt', '00003.2.flt')
    """
    number, *count, suffix = file.split(".")
    return f"{number}.{int(*count) + 1}.{suffix}"


def write_tile(
    folder: str | os.PathLike[str],
    number: int,
    lines: AnyGeometry,
    ids: IntArray,
    places: IntArray | None,
    frame: FloatArray,
    method: str | None = None,
    *,
    file: str | None = None,
    **settings: Any,
) -> TileFacts:
    """Build the tree of a tile and write it with its layout; the same input makes the same bytes.

    Parameters
    ----------
    folder : path
        It exists.
    number : int
        Tiles count from 0.
    lines : Lines
        The primitives of the tile, with the strands of the whole input.
    ids : (n,) int64
        Their numbers in the whole, rising.
    places : (n,) int64, optional
        The positions of the primitives among those of their strands; -1 for none. None if there are no strands.
    frame : (2, 3) float32
        That of the forest.
    method, **settings
        As `build` takes them.
    file : str, optional
        The name of the file, if it is not ``tile_name(number)``.
    """
    tree = build(lines, method, frame=frame, **settings)
    more: container.Arrays = {"ids": np.asarray(ids, np.int64)}
    if places is not None:
        more["places"] = np.asarray(places, np.int64)
    path = Path(folder) / (file or tile_name(number))
    tree_file.write(tree, path, layout=True, more=more)
    return tile_facts(tree, path)


def tile_facts(tree: Tree, path: Path) -> TileFacts:
    """Return what a manifest says of a tile, from its tree and its file."""
    geometry = tree.geometry
    least, most = geometry.radius_range or (0.0, 0.0)
    counts = len(geometry), tree.n_refs, np.array(tree.box)
    n_bytes = path.stat().st_size
    return TileFacts(path.name, *counts, least, most, geometry.total_length, n_bytes, container.digest(path))


def manifest_of_tree(path: Path, verify: bool | None = None) -> Manifest:
    """Return the manifest of the forest that a tree file is: of one tile."""
    tree = tree_file.read(Tree, path, verify)
    set_verified(path, verify)
    geometry = tree.geometry
    counts = len(geometry), geometry.n_strands
    return Manifest(tree.frame_box, *counts, (tile_facts(tree, path),), "", tree.method, facts_of(geometry))


def facts_of(lines: AnyGeometry) -> dict[str, Any]:
    """Return what a manifest says of the lines of a forest as a whole."""
    return {"up": lines.up, "unit": lines.unit, "metadata": lines.metadata}
