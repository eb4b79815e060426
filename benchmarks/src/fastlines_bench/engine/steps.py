"""The cost of a ray by steps: the number of steps of each kind, the time of each alone, and the time of a ray."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

import numpy as np

from fastlines import InputError, Tree, build, simd

from ..harness import machine
from ..harness.clock import best_of
from ..harness.internals import num_threads, use_engine
from ..harness.preset import TimedPreset, sized
from ..harness.rays import KINDS, RayBatch
from ..harness.subjects import Subject
from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from ..harness.turns import query_tree

#: The steps that are counted (kernels/cost/step_counters.hpp) and timed (benchmarks/cpp/step_timings.hpp).
STEPS = {
    "rays": "a ray prepared",
    "nodes": "a node culled: 16 boxes",
    "leaves": "a leaf culled: 16 pieces",
    "segments": "a segment loaded for a bundle",
    "lines": "a line test of a segment against 16 rays",
    "packets": "an exact test of 16 pairs",
    "tests": "an exact test of one pair",
}

#: The maximum number of rays on which steps are counted.
COUNTED = 1 << 16

#: How often a ray is repeated: `kGroupSize` (kernels/rays/ray_group.hpp), so that a group holds one ray.
REPEATS = 64


@dataclass(frozen=True, kw_only=True)
class StepsPreset(TimedPreset):
    """How much to measure, on one thread.

    Parameters
    ----------
    kinds : tuple of str
        Kinds of rays: keys of `rays.KINDS`.
    """

    n_rays: int = sized(1 << 18, 1 << 14)
    rounds: int = sized(5, 2)
    kinds: tuple[str, ...] = ("camera", "random", "ao")


@dataclass(frozen=True)
class StepCell:
    """One query on one kind of rays.

    Attributes
    ----------
    per_ray : dict of str to float
        Steps of each kind per ray; `pieces` survive the culling of leaves, `bundles` are traversed.
    bound_ns : float
        The sum of the times of a ray's steps, each timed alone: a lower bound for `ns`.
    ns : float
        The time of a ray.
    again_ns : float or None
        The time of a ray that is traced `REPEATS` times in a row, which leaves few cache misses and mispredicts. None
        for coherent rays.
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
    """All cells, and for each scene the nanoseconds of each step alone."""

    machine: dict[str, Any]
    alone: dict[str, dict[str, float]]
    cells: list[StepCell]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"format": "fastlines-bench steps 2", **asdict(self)}


def run_steps(
    subjects: list[Subject],
    preset: StepsPreset,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> StepResult:
    """Count and time the steps of all queries, on one thread.

    Parameters
    ----------
    subjects : list of Subject
    preset : StepsPreset
        At most `COUNTED` of its rays are counted; all are timed.
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    cells: list[StepCell] = []
    alone: dict[str, dict[str, float]] = {}
    n_cells = sum(len(subject.radii) * sum(len(KINDS[kind]) for kind in preset.kinds) for subject in subjects)
    for subject in subjects:
        progress(f"{subject.name}: building", len(cells) / n_cells)
        tree = build(subject.lines)
        fixed = {kind: subject.rays(kind, preset.n_rays) for kind in ("camera", "random")}
        with num_threads(1):
            for radius in subject.radii:
                alone[subject.name] = _time_steps(tree, fixed["camera"], radius, alone.get(subject.name, {}))
                for kind in preset.kinds:
                    rays = subject.occlusion_rays(tree, radius, preset.n_rays) if kind == "ao" else fixed[kind]
                    for query in KINDS[kind]:
                        progress(f"{subject.name}, radius {radius:g}: {kind} rays, {query}", len(cells) / n_cells)
                        cells.append(_cell(subject.name, tree, rays, radius, query, preset.rounds, alone[subject.name]))
    return StepResult(machine.describe(threads=1), alone, cells)


def count_steps(tree: Tree, query: str, rays: RayBatch, radius: float) -> tuple[dict[str, float], Any]:
    """Query a tree with the counting engine, on one thread; return the steps per ray, by name, and the answer."""
    module = compiled("_counting")
    assert tree.layout  # built by the usual engine; the counting one only queries
    with use_engine(module):
        module.take_steps()
        answer = query_tree(tree, query, rays, radius)
        taken = module.take_steps()
    return {name: n / max(1, len(rays)) for name, n in taken.items()}, answer


def _time_steps(tree: Tree, rays: RayBatch, radius: float, known: dict[str, float]) -> dict[str, float]:
    """Time each step alone with the current instruction set; return the least nanoseconds so far, by name."""
    layout = tree.layout
    now: dict[str, float] = compiled(f"_step_timings_{simd()}").time_steps(
        layout.geometry.core_rows,
        layout.nodes,
        layout.leaves,
        layout.refs,
        tuple(layout.box.ravel().tolist()),
        rays.origins,
        rays.directions,
        radius,
    )
    return {name: min(nanoseconds, known.get(name, nanoseconds)) for name, nanoseconds in now.items()}


@cache
def compiled(name: str) -> Any:
    """Import and return a compiled module of the benchmarks."""
    try:
        return importlib.import_module(f"fastlines_bench.{name}")
    except ImportError:
        raise InputError(
            f"fastlines-bench was built without its module {name}; install it from the repository with all "
            "instruction sets:  pip install -C cmake.define.FASTLINES_SIMD=all ./benchmarks"
        ) from None


def _cell(
    scene: str, tree: Tree, rays: RayBatch, radius: float, query: str, rounds: int, alone: dict[str, float]
) -> StepCell:
    per_ray, _ = count_steps(tree, query, rays.part(COUNTED), radius)
    bound = sum(per_ray[name] * alone[name] for name in STEPS)
    repeated = None if rays.coherent else rays.take(np.repeat(np.arange(0, len(rays), REPEATS), REPEATS))
    best, again_ns = float("inf"), None
    for _ in range(rounds):
        best = min(best, best_of(1, 1, lambda: query_tree(tree, query, rays, radius))[0])
        if repeated is not None:
            seconds, _answer = best_of(1, 1, lambda: query_tree(tree, query, repeated, radius, "wave"))
            again_ns = min(again_ns or float("inf"), seconds / len(repeated) * 1e9)
    return StepCell(scene, radius, rays.kind, query, len(rays), per_ray, bound, best / len(rays) * 1e9, again_ns)


def print_steps(result: StepResult) -> None:
    """Print the time of each step alone, and the steps and times of each query."""
    console = wide_console()
    timings = new_table("a step alone: nanoseconds (cycles)", ["step"], result.alone)
    for step, meaning in STEPS.items():
        cells = [f"{alone[step]:.1f} ({alone[step] / alone['cycle']:.0f})" for alone in result.alone.values()]
        timings.add_row(meaning, *cells)
    print_table(console, timings)

    table = new_table("steps a ray, and nanoseconds", ["scene"], [])
    counted = ("bundles", "nodes", "leaves", "pieces", "lines", "packets", "tests")
    for head in ("radius", "rays", "query", *counted, "sum", "a ray", "share", "again"):
        table.add_column(head, justify="left" if head in ("rays", "query") else "right", no_wrap=True)
    for cell in result.cells:
        shares = [format_3_digits(cell.per_ray[name]) if cell.per_ray[name] else "–" for name in counted]
        table.add_row(
            cell.scene,
            f"{cell.radius:g}",
            cell.kind,
            cell.query,
            *shares,
            f"{cell.bound_ns:.0f}",
            f"{cell.ns:.0f}",
            f"{cell.bound_ns / cell.ns:.2f}",
            "–" if cell.again_ns is None else f"{cell.again_ns:.0f}",
        )
    print_table(console, table)
    console.print(
        f"One thread, {result.machine['simd']}. sum: the times of a ray's steps, each timed alone; it leaves "
        "out traversal stacks, compression and sorting. a ray: the whole time. share: sum / a ray. again: the time of "
        f"a ray that is traced {REPEATS} times in a row, with few cache misses and mispredicts.",
        highlight=False,
    )
