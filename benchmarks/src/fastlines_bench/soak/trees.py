"""From a case to what is queried: the geometry, the tree, and what users do with trees."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.internals import as_geometry, num_threads, write_forest
from .case import FORESTS, Case
from .parts import Part


@dataclass(frozen=True)
class Subject:
    """What answers the questions of a case, and the geometry by which brute force answers them."""

    tree: Any
    #: What brute force answers by: the geometry of the tree, or of a scene that has its frame.
    geometry: Any
    #: The number of primitives of the tree; what comes after them makes the scene as large as the frame.
    n_prims: int
    #: What rays and points are less of: the offset, for a tree without its offset.
    less: tuple[float, ...] | None = None


def geometry_of(case: Case, spoiled: tuple[int, ...] = ()) -> Any:
    """Return the geometry of a case, with spoiled rows or without."""
    made = [part.made(case.offset, spoiled) for part in case.parts]
    return as_geometry(made[0] if len(made) == 1 else fl.Geometry(made))


def moved(part: Part) -> Part:
    """Return the part after its lines have moved."""
    return replace(part, rows={**part.rows, "ends": part.rows["moved"]})


@contextmanager
def on(simd: str | None, n_threads: int) -> Iterator[None]:
    """Compute with an instruction set and a number of threads."""
    fl.set_simd(simd)
    try:
        with num_threads(n_threads):
            yield
    finally:
        fl.set_simd(None)


def subject_of(case: Case, folder: Path) -> Subject:
    """Build the tree of a case, and do with it what the steps say."""
    geometry, given = geometry_of(case), geometry_of(case, case.spoiled)
    n_prims = len(geometry)
    if set(case.steps) & set(FORESTS):
        return Subject(_forest(case, given, folder), geometry, n_prims)
    tree: Any = fl.build(given, **case.build, frame=case.frame)
    if case.frame is not None:
        geometry = geometry_of(case.whole)
    less = None
    for step in case.steps:
        match step:
            case "layout":
                _ = tree.layout
            case "pickle":
                tree = pickle.loads(pickle.dumps(tree))
            case "save" | "save with layout":
                tree.save(folder / "tree.flt", layout=step != "save")
                tree = fl.load(folder / "tree.flt")
            case "refit":
                geometry = geometry_of(replace(case, parts=tuple(map(moved, case.parts))))
                tree = tree.refit(geometry.segments.astype(np.float64) + np.array(geometry.offset))
            case "without offset":
                tree, less = tree.without_offset(), case.offset
            case "forest of one file":
                tree.save(folder / "tree.flt", layout=True)
                tree = fl.Forest(folder / "tree.flt")
    return Subject(tree, geometry, n_prims, less)


def _forest(case: Case, lines: fl.Lines, folder: Path) -> fl.Forest:
    """Write a forest whose tiles are given, or build one; a mapped one answers by tasks."""
    (step,) = case.steps
    n_tiles = max(1, min(case.n_tiles, len(lines)))
    if step == "forest":
        settings = {name: value for name, value in case.build.items() if name != "method"}
        tile_of = np.arange(len(lines)) * 7 % n_tiles
        return write_forest(lines, folder / "forest", tile_of, case.build.get("method"), **settings)
    most = -(-len(lines) // n_tiles) or 1
    offset = case.offset if len(lines) else None
    forest = fl.build_forest([lines], folder / "forest", max_segments=most, offset=offset, **case.build)
    return forest.on(map) if step == "mapped forest" else forest
