"""The operations whose allocations fail: builds, layouts, queries, refits, files and pictures, on a small scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
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
    """A call whose allocations fail: what it needs, made anew for each call, and the call, which returns arrays."""

    name: str
    prepare: Callable[[], Any]
    call: Callable[[Any], Any]


def arrays_of(answer: Any) -> list[bytes]:
    """Return the bytes of all arrays of an answer."""
    if isinstance(answer, np.ndarray):
        return [answer.tobytes()]
    if isinstance(answer, bytes):
        return [answer]
    if isinstance(answer, list | tuple):
        return [part for each in answer for part in arrays_of(each)]
    columns = (getattr(answer, name, None) for name in COLUMNS)
    return [part for column in columns if isinstance(column, np.ndarray) for part in arrays_of(column)]


#: What answers and trees have, as far as they have it.
COLUMNS = "offsets t prim u distance t_out i j s values count entry exit low high words areas left right segments".split()


def scene() -> fl.Lines:
    """Return short lines in all directions, in a box of size 1."""
    rng = np.random.default_rng(1)
    begins = rng.random((N_LINES, 1, 3))
    segments = np.concatenate([begins, begins + rng.normal(0, 0.2, begins.shape)], axis=1)
    return fl.Lines.from_strands(list(segments))


class Operations:
    """All operations, over trees in a folder."""

    def __init__(self, folder: Path) -> None:
        rng = np.random.default_rng(2)
        self.lines = scene()
        self.folder = folder
        self.file = folder / "tree.flt"
        self.tree = fl.build(self.lines)
        self.tree.save(self.file)
        self.origins = rng.normal(0, 1, (N_RAYS, 3)) + 0.5
        self.directions = rng.random((N_RAYS, 3)) - self.origins
        self.points = rng.random((N_RAYS, 3))
        self.values = rng.random((N_LINES, 3))
        self.round = fl.build(self.lines.with_radius(0.01))

    def check(self) -> list[bytes]:
        """Return what a tree from before answers, in several queries."""
        rays = (self.origins, self.directions, RADIUS)
        return arrays_of([self.tree.first_hit(*rays), self.tree.all_hits(*rays), self.tree.nearest(self.points)])

    def __iter__(self) -> Iterator[Operation]:
        for method in ("best", "bvh-cl", "bvh-d2", "kd-cl", "kd-d2"):
            yield Operation(f"build {method}", lambda: None, lambda _, m=method: fl.build(self.lines, m))
        more = {"presplit": fl.Presplit(), "reinsertion": 2}
        for name, value in more.items():
            yield Operation(f"build {name}", lambda: None, lambda _, n=name, v=value: fl.build(self.lines, **{n: v}))
        yield Operation("layout", lambda: fl.build(self.lines), lambda tree: [tree.layout.nodes, tree.layout.leaves])
        yield from self._rays()
        yield from self._others()
        yield from self._files()

    def _rays(self) -> Iterator[Operation]:
        tree, rays = self.tree, (self.origins, self.directions, RADIUS)

        def of(name: str, call: Callable[[], Any]) -> Operation:
            return Operation(name, lambda: None, lambda _: call())

        for query in ("first_hit", "any_hit", "count_hits", "all_hits"):
            yield of(query, lambda q=query: getattr(tree, q)(*rays))
            yield of(f"{query}, one ray", lambda q=query: getattr(tree, q)(rays[0][0], rays[1][0], 0.1))
        yield of("next_hits", lambda: tree.next_hits(*rays, k=3))
        yield of("next_hits by distance", lambda: tree.next_hits(*rays, k=3, rank="distance"))
        yield of("first_hit at surfaces", lambda: self.round.first_hit(*rays, at="surface"))
        yield of("all_hits of crossings", lambda: self.round.all_hits(*rays, at="surface", merge="strand"))
        yield of("all_hits with a spread", lambda: self.round.all_hits(*rays, spread=0.01))
        yield of("all_hits, some ignored", lambda: tree.all_hits(*rays, ignore=[1, 2, 3]))
        yield of("iter_all_hits", lambda: list(tree.iter_all_hits(*rays, max_bytes=1 << 16)))
        yield of("gather", lambda: tree.gather(*rays, self.values))
        for kernel in ("bundle", "wave", "single", "binary"):
            yield of(f"all_hits, {kernel}", lambda k=kernel: tree.all_hits(*rays, kernel=k))
        yield of("brute_force", lambda: fl.brute_force(self.lines, *rays))

    def _others(self) -> Iterator[Operation]:
        tree, points = self.tree, self.points

        def of(name: str, call: Callable[[], Any]) -> Operation:
            return Operation(name, lambda: None, lambda _: call())

        yield of("nearest", lambda: tree.nearest(points))
        yield of("nearest, k", lambda: tree.nearest(points, k=5))
        yield of("within", lambda: tree.within(points, 0.1))
        yield of("count_within", lambda: tree.count_within(points, 0.1))
        yield of("pairs", lambda: tree.pairs(RADIUS))
        yield of("iter_pairs", lambda: list(tree.iter_pairs(RADIUS, max_bytes=1 << 16)))
        yield of("in_box", lambda: tree.in_box([0.2] * 3, [0.6] * 3))
        yield of("along", lambda: tree.along(points[:5], 0.1))
        yield of("refit", lambda: tree.refit(self.lines.segments + np.float32(0.01)))
        yield of("validate", lambda: [tree.validate()][:0])

    def _files(self) -> Iterator[Operation]:
        def saved() -> Any:
            self.tree.save(self.folder / "again.flt", layout=True)
            return (self.folder / "again.flt").read_bytes()

        def wrote() -> Any:
            fl.write(self.folder / "lines.tck", self.lines)
            return (self.folder / "lines.tck").read_bytes()

        yield Operation("save", lambda: None, lambda _: saved())
        yield Operation("load", lambda: None, lambda _: fl.load(self.file))
        yield Operation("write lines", lambda: None, lambda _: wrote())
        yield Operation("read lines", lambda: wrote(), lambda _: fl.read(self.folder / "lines.tck"))
        for look in ("depth", "hair"):
            yield Operation(f"render {look}", lambda: None, lambda _, k=look: self._picture(k))

    def _picture(self, look: str) -> Any:
        return np.asarray(fl.render(self.tree, width=24, height=16, samples=1, look=look, radius=0.01).to_bytes())
