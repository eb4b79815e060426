"""Lines that run along each other: trees of "best", which leaves them whole, and trees that cut them.

Each scene has three trees: of `best`, of `best` without `min_spread`, and the latter with at most 1.05 references per
segment. A row has the references per segment, the times of the build and the layout, and the size of the layout with
its segments. Another row has the query times as multiples of the second tree's. Queries are alternated on one thread,
and their answers are compared. With an aim of least cost, only the costs of the first two trees are printed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

import fastlines as fl

from ..builders.trees import alternate_queries, time_layout
from ..harness.clock import clock
from ..harness.internals import num_threads
from ..harness.subjects import Subject

Ends = npt.NDArray[np.float32]


def staggered(spread: float, n: int = 100_000) -> Ends:
    """Return pieces of one line with random starts, each offset by up to `spread` along each axis."""
    rng = np.random.default_rng(1)
    axis = np.array([1.0, 0.7, 0.4])
    starts = rng.random((n, 1)) * axis + rng.uniform(-spread, spread, (n, 3))
    return np.stack([starts, starts + 0.1 * axis], axis=1).astype(np.float32)


def circling(n_orbits: int, n_windings: int = 1000, n_steps: int = 50, drift: float = 1e-4) -> Ends:
    """Return flow lines on closed orbits, in which each winding retraces the one before, up to a drift."""
    rng = np.random.default_rng(2)
    segments = []
    for _ in range(n_orbits):
        (a, b, _), _ = np.linalg.qr(rng.normal(size=(3, 3)))
        a, b, centre = a * rng.uniform(0.2, 1.0), b * rng.uniform(0.2, 1.0), rng.normal(size=3) * 0.2
        # Let a winding not be a whole number of steps.
        angle = np.arange(n_windings * n_steps + 1)[:, None] * (2 * np.pi / (n_steps + 0.37))
        walk = np.cumsum(rng.normal(size=(len(angle), 3)), axis=0)
        points = centre + np.cos(angle) * a + np.sin(angle) * b + drift * walk / np.abs(walk).max()
        segments.append(np.stack([points[:-1], points[1:]], axis=1))
    return np.concatenate(segments).astype(np.float32)


SCENES: dict[str, Callable[[], Ends]] = {
    "one-line": lambda: staggered(0.0),
    "one-line-10k": lambda: staggered(0.0, 10_000),
    "apart-0.0005": lambda: staggered(0.0005),
    "apart-0.001": lambda: staggered(0.001),
    "apart-0.01": lambda: staggered(0.01),
    "circling": lambda: circling(10),
    "circling-large": lambda: circling(66),
}
AIMS: dict[str, dict[str, Any]] = {"queries": {}, "bvh": {"cost": fl.Cost(2.0)}, "kd": {"boxes": "cut"}}


def lines_of(scene: str) -> fl.Lines:
    """Return the lines of a scene of this file or of the thesis."""
    return fl.Lines.from_segments(SCENES[scene]()) if scene in SCENES else fl.scenes.make(scene).lines


def compare(scene: str, lines: fl.Lines, effort: float, aim: str, radii: list[float]) -> None:
    """Print a row for each tree and, for queries, for each radius."""
    now = clock(1)
    capped = fl.Limits(max_refs=int(1.05 * len(lines)))
    variants: dict[str, dict[str, Any]] = {"best": {}, "cut": {"min_spread": 0.0}}
    if aim == "queries":
        variants["capped"] = {"min_spread": 0.0, "limits": capped}
    trees = {}
    for name, more in variants.items():
        start = now()
        tree = trees[name] = fl.build(lines, "best", effort=effort, **AIMS[aim], **more)
        row = f"{scene:14} {aim:7} {effort:6g} {name:6} {tree.n_refs / len(lines):8.3f} {now() - start:7.2f} s"
        if aim == "queries":
            print(f"{row} {time_layout(tree):6.2f} s {tree.layout.n_bytes / 1e6:8.1f} MB", flush=True)
        else:
            print(f"{row} cost {tree.cost():10.2f}", flush=True)
    if aim != "queries":
        return
    side = float((lines.bounds[1] - lines.bounds[0]).max())
    for radius in radii:
        subject = Subject(scene, lines, fl.Camera.framing(lines), (radius * side,))
        timings = alternate_queries(subject, trees, 1 << 18, 0.1, 5)
        for name in trees:
            ratios = [
                f"{question} {each.seconds[name] / each.seconds['cut']:.2f}" for question, each in timings.items()
            ]
            print(f"{scene:14} {aim:7} {effort:6g} {name:6} radius {radius:g}: {', '.join(ratios)}", flush=True)


def print_retraced(scenes: list[str], aims: list[str], efforts: list[float], radii: list[float]) -> None:
    """Compare the trees of each scene, for each aim and effort."""
    with num_threads(1):
        for scene in scenes:
            lines = lines_of(scene)
            for aim in aims:
                for effort in efforts:
                    compare(scene, lines, effort, aim, radii)
