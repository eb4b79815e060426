"""The operations whose allocations fail: builds, layouts, queries, refits, files and pictures, on a small scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

#: Lines of the scene, rays and points of a query, and threads that answer it.
N_LINES, N_RAYS, N_THREADS = 400, 800, 3

#: The radius of queries, in a scene of size 1: some rays hit nothing, and some hit dozens of lines.
RADIUS = 0.02


@dataclass(frozen=True)
class Operation:
    """A call whose allocations fail: `prepare` makes what it needs, and returns the call, which returns arrays."""

    name: str
    prepare: Callable[[], Callable[[], Any]]


#: What answers and trees have, as far as they have it.
COLUMNS = (
    *("offsets", "t", "prim", "u", "distance", "t_out", "i", "j", "s", "values", "count"),
    *("entry", "exit", "low", "high", "words", "areas", "left", "right", "segments"),
)


def arrays_of(answer: Any) -> list[bytes]:
    """Return the bytes of all arrays of an answer."""
    if answer is None:
        return []
    if isinstance(answer, np.ndarray):
        return [answer.tobytes()]
    if isinstance(answer, bytes):
        return [answer]
    if isinstance(answer, list | tuple):
        return [part for each in answer for part in arrays_of(each)]
    columns = (getattr(answer, name, None) for name in COLUMNS)
    return [part for column in columns if isinstance(column, np.ndarray) for part in arrays_of(column)]


def joined(parts: Iterable[Any]) -> list[Any]:
    """Return the columns of all parts of an answer. Where memory is short, the parts are smaller, and more."""
    several = list(parts)
    names = [name for name in COLUMNS if name != "offsets" and isinstance(getattr(several[0], name, None), np.ndarray)]
    return [np.concatenate([getattr(part, name) for part in several]) for name in names]


def scene() -> fl.Lines:
    """Return short lines in all directions, in a box of size 1."""
    rng = np.random.default_rng(1)
    begins = rng.random((N_LINES, 1, 3))
    segments = np.concatenate([begins, begins + rng.normal(0, 0.2, begins.shape)], axis=1)
    return fl.Lines.from_strands(list(segments))


def of(name: str, function: Callable[..., Any], *arguments: Any, **options: Any) -> Operation:
    """Return the operation that calls a function with these arguments."""
    call = partial(function, *arguments, **options)
    return Operation(name, lambda: call)


class Operations:
    """All operations, over trees in a folder."""

    def __init__(self, folder: Path) -> None:
        rng = np.random.default_rng(2)
        self.lines = scene()
        self.folder = folder
        self.file = folder / "tree.flt"
        self.tree = fl.build(self.lines)
        self.tree.save(self.file)
        origins = rng.normal(0, 1, (N_RAYS, 3)) + 0.5
        self.rays = (origins, rng.random((N_RAYS, 3)) - origins, RADIUS)
        self.points = rng.random((N_RAYS, 3))
        self.values = rng.random((N_LINES, 3))
        self.round = fl.build(self.lines.with_radius(0.01))
        moved = self.lines.segments + np.float32(0.1)
        self.parts = fl.build(fl.Geometry([self.lines, fl.Lines.from_strands(list(moved)).with_radius(0.01)]))
        self.forest = fl.build_forest(self.lines, folder / "forest", max_segments=N_LINES // 3)

    def check(self) -> list[bytes]:
        """Return what a tree from before answers, in several queries."""
        first, every = self.tree.first_hit(*self.rays), self.tree.all_hits(*self.rays)
        return arrays_of([first, every, self.tree.nearest(self.points)])

    def __iter__(self) -> Iterator[Operation]:
        for method in ("best", "bvh-cl", "bvh-d2", "kd-cl", "kd-d2"):
            yield of(f"build {method}", fl.build, self.lines, method)
        yield of("build with a presplit", fl.build, self.lines, presplit=fl.Presplit())
        yield of("build with reinsertion", fl.build, self.lines, reinsertion=2)
        yield Operation("layout", self._prepare_layout)
        yield of("refit", self.tree.refit, self.lines.segments + np.float32(0.01))
        yield of("validate", self.tree.validate)
        yield from self._of_rays()
        yield from self._of_points()
        yield from self._of_files()

    def _prepare_layout(self) -> Callable[[], Any]:
        tree = fl.build(self.lines)
        return lambda: [tree.layout.nodes, tree.layout.leaves]

    def _of_rays(self) -> Iterator[Operation]:
        tree, rays = self.tree, self.rays
        for query in ("first_hit", "any_hit", "count_hits", "all_hits"):
            yield of(query, getattr(tree, query), *rays)
            yield of(f"{query}, one ray", getattr(tree, query), rays[0][0], rays[1][0], 0.1)
        yield of("next_hits", tree.next_hits, *rays, k=3)
        yield of("next_hits by distance", tree.next_hits, *rays, k=3, rank="distance")
        yield of("first_hit at surfaces", self.round.first_hit, *rays, at="surface")
        yield of("all_hits of crossings", self.round.all_hits, *rays, at="surface", merge="strand")
        yield of("all_hits with a spread", self.round.all_hits, *rays, spread=0.01)
        yield of("all_hits, some ignored", tree.all_hits, *rays, ignore=[1, 2, 3])
        yield of("all_hits of parts", self.parts.all_hits, *rays)
        yield of("all_hits of a forest", self.forest.all_hits, *rays)
        yield of("iter_all_hits", lambda: joined(tree.iter_all_hits(*rays, max_bytes=1 << 16)))
        yield of("gather", tree.gather, *rays, self.values)
        for kernel in ("bundle", "wave", "single", "binary"):
            yield of(f"all_hits, {kernel}", tree.all_hits, *rays, kernel=kernel)
        yield of("brute_force", fl.brute_force, self.lines, *rays)

    def _of_points(self) -> Iterator[Operation]:
        tree, points = self.tree, self.points
        yield of("nearest", tree.nearest, points)
        yield of("nearest, some ignored", tree.nearest, points, k=5, ignore=[1, 2, 3])
        yield of("nearest of parts", self.parts.nearest, points)
        yield of("nearest of a forest", self.forest.nearest, points)
        yield of("within", tree.within, points, 0.1)
        yield of("within of parts", self.parts.within, points, 0.1)
        yield of("count_within", tree.count_within, points, 0.1)
        yield of("pairs", tree.pairs, RADIUS)
        yield of("pairs of parts", self.parts.pairs, RADIUS)
        yield of("iter_pairs", lambda: joined(tree.iter_pairs(RADIUS, max_bytes=1 << 16)))
        yield of("in_box", tree.in_box, [0.2] * 3, [0.6] * 3)
        yield of("along", tree.along, points[:5], 0.1)

    def _of_files(self) -> Iterator[Operation]:
        yield of("save", self._save)
        yield of("load", fl.load, self.file)
        yield of("write lines", self._write)
        yield of("read lines", self._read)
        for look in ("depth", "hair"):
            yield of(f"render {look}", self._picture, look)

    def _save(self) -> bytes:
        path = self.folder / "again.flt"
        self.tree.save(path, layout=True)
        return path.read_bytes()

    def _write(self) -> bytes:
        path = self.folder / "lines.npz"
        fl.write(path, self.lines)
        return path.read_bytes()

    def _read(self) -> Any:
        if not (self.folder / "lines.npz").exists():
            self._write()
        return fl.read(self.folder / "lines.npz")

    def _picture(self, look: str) -> Any:
        return fl.render(self.tree, width=24, height=16, samples=1, look=look, radius=0.01).to_bytes()
