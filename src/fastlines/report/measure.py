"""Figures of trees over the same lines: builds and queries are timed, and answers compared bit for bit."""

from __future__ import annotations

import datetime
import platform
import re
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

import fastlines as fl

from ..scenes import RADII

#: One cost model for all trees of a kind, by the boxes of their settings (thesis §3.3).
COSTS = {"tight": fl.Cost(2.0), "cut": fl.Cost(0.6)}

#: The queries that are timed: first and all hits, with each of the thesis's radii.
QUERIES = tuple((query, letter) for query in ("first", "all") for letter in RADII)

#: The rays of a square picture of up to COMPARED pixels a side are compared: fewer, if they take more than TESTS tests.
COMPARED, TESTS = 64, 4e7

#: What is called with the part of a step that is done, from 0 to 1.
Watch: TypeAlias = Callable[[float], object]

#: The least and the most rounds of a timing, in which trees take turns; the best time counts.
LEAST, MOST = 3, 20

#: About how many hits one query may list.
MAX_HITS = 1 << 22


@dataclass(frozen=True)
class TreeFigures:
    """One tree over some lines."""

    method: str
    #: Seconds of the build and of the layout.
    build_s: float = 0.0
    n_refs: int = 0
    n_nodes: int = 0
    depth: int = 0
    #: By the cost model of its kind, `COSTS`.
    cost: float = 0.0
    #: Memory of the layout and the segments.
    bytes: int = 0
    #: Millions of rays a second: of each query ("first W", …), and of a search of the binary tree with the radius M.
    mrays: dict[str, float] = field(default_factory=dict)
    as_built: dict[str, float] = field(default_factory=dict)
    #: By which part the median round of each timing, in their order, took longer than the best.
    noise: list[float] = field(default_factory=list)
    #: How many answers equal those of the reference tree.
    n_compared: int = 0
    #: The limit in seconds that the build exceeded; then nothing else is known.
    over_s: float | None = None


def build_within(lines: fl.Lines, method: str, limit: float, watch: Watch) -> tuple[fl.Tree | None, float]:
    """Build a tree with its layout, validate it, and return it with its seconds; None if the build exceeds a limit."""
    start = time.perf_counter()

    def check(share: float) -> None:
        if time.perf_counter() - start > limit:
            raise TimeoutError
        watch(share)

    try:
        tree = fl.build(lines, method, progress=check)
    except TimeoutError:
        return None, limit
    tree.layout  # noqa: B018
    seconds = time.perf_counter() - start
    tree.validate()
    return tree, seconds


def measure_tree(tree: fl.Tree, build_s: float, reference: fl.Tree, camera: fl.Camera, radius: float) -> TreeFigures:
    """Return the figures of a tree except those of its queries; refuse it if an answer differs from the reference's."""
    cost = tree.cost(model=COSTS[tree.settings.boxes])
    size = int(np.clip((TESTS / cost) ** 0.5, 4, COMPARED))
    n_compared = sum(compare(tree, reference, camera, radius, kernel, size) for kernel in ("auto", "binary"))
    depth, n_bytes = tree.stats()["depth"], int(tree.layout.n_bytes)
    return TreeFigures(tree.method, build_s, tree.n_refs, tree.n_nodes, depth, cost, n_bytes, n_compared=n_compared)


def trace(tree: fl.Tree, query: str, rays: tuple[Any, Any], radius: float, kernel: str) -> Any:
    """Find first or all hits."""
    return (tree.first_hit if query == "first" else tree.all_hits)(*rays, radius, kernel=kernel)


def compare(tree: fl.Tree, reference: fl.Tree, camera: fl.Camera, radius: float, kernel: str, size: int) -> int:
    """Refuse a tree whose answers differ from the reference's in any bit; return how many were compared."""
    rays = camera.rays(size, size)
    for query in ("first", "all"):
        mine, expected = trace(tree, query, rays, radius, kernel), trace(reference, query, rays, radius, "auto")
        for name in ("offsets", "t", "prim", "u", "distance"):
            if hasattr(mine, name) and not np.array_equal(getattr(mine, name), getattr(expected, name)):
                raise fl.FastlinesError(
                    f"{tree.method} and {reference.method} answer {query} hits differently ({name}); this is a bug in "
                    "fastlines, please report it"
                )
    return 2 * size * size


def time_in_turn(
    trees: Mapping[str, fl.Tree],
    query: str,
    radius: float,
    kernel: str,
    camera: fl.Camera,
    size: int,
    budget: float,
    watch: Watch,
) -> dict[str, tuple[float, float]]:
    """Time a query on trees in turn; return by name the millions of rays a second of the best round, and the noise.

    The noise is the part by which the median round took longer than the best.

    The rays are those of a square picture of `size` pixels a side, or fewer where a turn would take more than `budget`
    seconds.
    """
    pixels = {name: _fitting(tree, query, radius, kernel, camera, size, budget) for name, tree in trees.items()}
    rays = {n: camera.rays(n, n) for n in set(pixels.values())}
    rounds: dict[str, list[float]] = {name: [] for name in trees}
    begun, n_rounds, whole = time.perf_counter(), 0, budget * len(trees)
    while n_rounds < LEAST or (n_rounds < MOST and time.perf_counter() - begun < whole):
        n_rounds += 1
        for name, tree in trees.items():
            start = time.perf_counter()
            trace(tree, query, rays[pixels[name]], radius, kernel)
            rounds[name].append(max(time.perf_counter() - start, 1e-9))
        watch(min(1.0, max(n_rounds / MOST, (time.perf_counter() - begun) / max(whole, 1e-9))))
    return {
        name: (pixels[name] ** 2 / min(seconds) / 1e6, statistics.median(seconds) / min(seconds) - 1)
        for name, seconds in rounds.items()
    }


def _fitting(tree: fl.Tree, query: str, radius: float, kernel: str, camera: fl.Camera, size: int, budget: float) -> int:
    """Return the side of the largest picture whose query fits into the budget, and its hits into `MAX_HITS`."""
    pixels = min(size, 8)
    while pixels < size:
        start = time.perf_counter()
        found = trace(tree, query, camera.rays(pixels, pixels), radius, kernel)
        seconds, n_hits = time.perf_counter() - start, len(found) if query == "all" else 0
        if 4 * seconds > budget or 4 * n_hits > MAX_HITS:
            break
        pixels = min(size, 2 * pixels)
    return pixels


def describe_machine() -> dict[str, str | int]:
    """Name the processor, the system and the versions that figures depend on."""
    return {
        "processor": _processor(),
        "threads": fl.get_num_threads(),
        "system": f"{platform.system()} {platform.machine()}",
        "fastlines": fl.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }


def _processor() -> str:
    """Return the name of the processor, as far as the system gives it."""
    try:
        found = re.search(r"^model name\s*:\s*(.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        found = None
    return found[1] if found else platform.processor() or platform.machine() or "unknown"
