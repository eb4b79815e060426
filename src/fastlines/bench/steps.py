"""What a ray costs, step by step: how many steps of each kind, how long each takes alone, and how long all took."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..backend import counting, engine, simd
from ..builder import build
from ..demo.machine import describe_machine
from ..rays import check_rays
from ..threads import num_threads
from ..tree import Tree
from .engine import Case, ask_tree, occlusion
from .rays import KINDS, RayBatch, camera_rays, random_rays
from .timing import clock

#: The steps that are counted and paced, as kernels/tally.hpp and kernels/pace.hpp have them.
STEPS = {
    "rays": "a ray prepared",
    "nodes": "a node culled: 16 boxes",
    "leaves": "a leaf culled: 16 pieces",
    "segments": "a segment set up for a bundle",
    "lines": "a segment's line seen by 16 rays from afar",
    "packs": "an exact test of 16",
    "tests": "an exact test of one",
}

#: A ray's steps are counted on so many rays at most.
COUNTED = 1 << 16

#: As many rays as are taken together: `kLanes` (kernels/lanes.hpp).
AGAIN = 64


@dataclass(frozen=True)
class StepCell:
    """One query on one kind of rays.

    Attributes
    ----------
    per_ray : dict of str to float
        Steps of each kind a ray; `pieces` are those that survive leaves, `bundles` those that are searched.
    bound_ns : float
        What the steps of a ray would take at their pace alone.
    ns : float
        What a ray takes.
    again_ns : float or None
        What one takes where every `AGAIN`th is asked so many times in a row: what it reads is in the nearest cache
        then, and hardly a guess is wrong. Of rays that go alone.
    """

    scene: str
    radius: float
    kind: str
    query: str
    n_rays: int
    per_ray: dict[str, float]
    bound_ns: float
    ns: float
    again_ns: float | None


@dataclass(frozen=True)
class StepResult:
    """All cells, and the pace of each scene: nanoseconds a step."""

    machine: dict[str, Any]
    pace: dict[str, dict[str, float]]
    cells: list[StepCell]

    def to_json(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {"format": "fastlines bench steps 1", **asdict(self)}


def run_steps(
    cases: list[Case],
    kinds: tuple[str, ...],
    n_rays: int = 1 << 18,
    rounds: int = 5,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> StepResult:
    """Count and time, on one thread.

    Parameters
    ----------
    cases : list of Case
    kinds : tuple of str
        Kinds of rays, of `rays.KINDS`.
    n_rays : int
        So many rays are timed, and at most `COUNTED` of them counted.
    rounds : int
        The best of so many times counts.
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    cells: list[StepCell] = []
    pace: dict[str, dict[str, float]] = {}
    n_cells = sum(len(case.radii) * sum(len(KINDS[kind]) for kind in kinds) for case in cases)
    machine = {**describe_machine(), "simd": simd()}
    for case in cases:
        progress(f"{case.name}: building", len(cells) / n_cells)
        tree = build(case.lines)
        fixed = {"camera": camera_rays(case.camera, n_rays), "random": random_rays(case.lines, n_rays)}
        with num_threads(1):
            for radius in case.radii:
                pace[case.name] = _pace(tree, fixed["camera"], radius, pace.get(case.name, {}))
                for kind in kinds:
                    rays = occlusion(case, tree, radius, n_rays) if kind == "ao" else fixed[kind]
                    for query in KINDS[kind]:
                        progress(f"{case.name}, radius {radius:g}: {kind} rays, {query}", len(cells) / n_cells)
                        cells.append(_cell(case.name, tree, rays, radius, query, rounds, pace[case.name]))
    return StepResult(machine, pace, cells)


def _pace(tree: Tree, rays: RayBatch, radius: float, known: dict[str, float]) -> dict[str, float]:
    layout = tree.layout
    checked = check_rays(rays.origins, rays.directions, radius, rays.t_min, rays.t_max, "error", layout.box)
    now: dict[str, float] = engine().pace(layout.arrays, checked.arrays())
    return {name: min(nanoseconds, known.get(name, nanoseconds)) for name, nanoseconds in now.items()}


def _cell(
    scene: str, tree: Tree, rays: RayBatch, radius: float, query: str, rounds: int, pace: dict[str, float]
) -> StepCell:
    few = rays.part(COUNTED)
    with counting() as module:
        module.taken()
        ask_tree(tree, query, few, radius)
        per_ray = {name: n / len(few) for name, n in module.taken().items()}
    bound = sum(per_ray[name] * pace[name] for name in STEPS)
    again = None if rays.coherent else rays.take(np.repeat(np.arange(0, len(rays), AGAIN), AGAIN))
    now, best, best_again = clock(1), float("inf"), float("inf")
    for _ in range(rounds):
        start = now()
        ask_tree(tree, query, rays, radius)
        best = min(best, now() - start)
        if again is not None:
            start = now()
            ask_tree(tree, query, again, radius, "wave")
            best_again = min(best_again, now() - start)
    again_ns = None if again is None else best_again / len(again) * 1e9
    return StepCell(scene, radius, rays.kind, query, len(rays), per_ray, bound, best / len(rays) * 1e9, again_ns)
