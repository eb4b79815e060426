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
from .case import Case
from .parts import Part


@dataclass(frozen=True)
class Subject:
    """What answers the questions of a case, and the geometry by which brute force answers them."""

    tree: Any
    geometry: Any
    #: What rays and points are less of: the offset, for a tree without its offset.
    less: tuple[float, ...] | None = None


def geometry_of(case: Case) -> Any:
    """Return the geometry that a case builds its tree over."""
    made = [part.made(case.offset) for part in case.parts]
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
    geometry = geometry_of(case)
    if "forest" in case.steps:
        tile_of = np.arange(len(geometry)) * 7 % max(1, min(case.n_tiles, len(geometry)))
        given = {name: value for name, value in case.build.items() if name != "method"}
        forest = write_forest(geometry, folder / "forest", tile_of, case.build.get("method"), **given)
        return Subject(forest, geometry)
    tree: Any = fl.build(geometry, **case.build)
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
    return Subject(tree, geometry, less)
