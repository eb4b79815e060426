"""The manifest of a forest, and a whole forest of lines in memory; each file is written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, to_integers
from ..errors import InputError
from ..geometry.lines import Lines
from ..query.proximity.strand_places import strand_places
from ..settings.methods import DEFAULT_METHOD
from ..support.immutable import own
from .index import SAMPLE_PRIMS, Index
from .manifest import Manifest, TileFacts
from .tile_files import facts_of, write_tile

if TYPE_CHECKING:
    from .forest import Forest


def write_manifest(
    folder: str | os.PathLike[str],
    frame: FloatArray,
    tiles: list[TileFacts],
    index: str,
    method: str,
    *,
    n_strands: int = 0,
    facts: Mapping[str, Any] | None = None,
) -> Manifest:
    """Write the manifest of a forest, whose tiles and index are there; so it comes last.

    Parameters
    ----------
    index : str
        The digest that `Index.write` returned.
    facts : mapping, optional
        ``up``, ``unit`` and ``metadata`` of the lines.
    """
    n_prims = sum(tile.n_prims for tile in tiles)
    manifest = Manifest(frame, n_prims, n_strands, tuple(tiles), index, method, facts or {}, version("fastlines"))
    manifest.write(folder)
    return manifest


def write_forest(
    lines: Lines,
    folder: str | os.PathLike[str],
    tile_of: npt.ArrayLike,
    method: str | None = None,
    **settings: Any,
) -> Forest:
    """Write a forest of lines in memory, whose tiles are given; `build_forest` divides lines of any number itself.

    Parameters
    ----------
    folder : path
        It is made if it does not exist.
    tile_of : (n,) array of int
        The tile of each segment; tiles count from 0.
    """
    from .forest import Forest

    given = to_integers(tile_of, "tile_of")
    if given.shape != (len(lines),) or given.min(initial=0) < 0:
        raise InputError(f"tile_of has shape {given.shape}; expected a tile for each of {len(lines)} segments, from 0")
    Path(folder).mkdir(exist_ok=True)
    known = strand_places(lines)
    frame = lines.bounds if len(lines) else np.zeros((2, 3), np.float32)
    tiles = []
    for number in range(int(given.max(initial=-1)) + 1):
        ids = np.flatnonzero(given == number)
        places = None if known is None else known[ids, 1].astype(np.int64)
        tiles.append(write_tile(folder, number, lines[ids], ids, places, frame, method, **settings))
    sampled = lines if settings.get("own_radius", True) else lines.without_radius()
    rows = np.arange(min(SAMPLE_PRIMS, len(lines))) * len(lines) // max(1, min(SAMPLE_PRIMS, len(lines)))
    closed = np.zeros((0, 2), np.int64)
    if known is not None:
        first = np.flatnonzero((known[:, 1] == 0) & (known[:, 2] > 0))
        first = first[np.argsort(lines.strands[first])]
        closed = np.stack([lines.strands[first], known[first, 2].astype(np.int64)], axis=1)
    strands = None if known is None else lines.strands
    index = Index(own(given.astype(np.uint32)), strands, lines.skipped, closed, sampled[rows]).write(folder)
    write_manifest(
        folder, frame, tiles, index, method or DEFAULT_METHOD, n_strands=lines.n_strands, facts=facts_of(lines)
    )
    return Forest(folder)
