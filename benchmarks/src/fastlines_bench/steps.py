"""What a ray costs, step by step: how many steps of each kind, how long each takes alone, and how long all took."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

import numpy as np

from fastlines import InputError, Tree, build, simd

from .harness import machine
from .harness.clock import best_of
from .harness.preset import TimedPreset, sized
from .harness.rays import KINDS, RayBatch
from .harness.subjects import Subject
from .harness.tables import format_3_digits, new_table, print_table, wide_console
from .harness.turns import ask_tree
from .package import num_threads, use_engine

#: The steps that are counted (kernels/cost/step_counters.hpp) and timed (benchmarks/cpp/step_timings.hpp).
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

#: As many rays as are taken together: `kGroupSize` (kernels/rays/ray_group.hpp).
AGAIN = 64


@dataclass(frozen=True, kw_only=True)
class StepsPreset(TimedPreset):
    """How much to measure; one thread.

    Parameters
    ----------
    kinds : tuple of str
        Kinds of rays, of `rays.KINDS`.
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
        Steps of each kind a ray; `pieces` are those that survive leaves, `bundles` those that are searched.
    bound_ns : float
        The sum of what the steps of a ray take alone.
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
    """All cells, and by scene the nanoseconds that each step takes alone."""

    machine: dict[str, Any]
    alone: dict[str, dict[str, float]]
    cells: list[StepCell]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"format": "fastlines-bench steps 1", **asdict(self)}


def run_steps(
    subjects: list[Subject],
    preset: StepsPreset,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> StepResult:
    """Count and time, on one thread.

    Parameters
    ----------
    subjects : list of Subject
    preset : StepsPreset
        At most `COUNTED` of its rays are counted; all are timed.
    progress : callable
        Called with what is being done, and which share of all is done.
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
    """Ask a tree with the engine that counts; return the steps a ray by name, and the answer. One thread only."""
    module = compiled("_counting")
    with use_engine(module):
        module.take_steps()
        answer = ask_tree(tree, query, rays, radius)
        taken = module.take_steps()
    return {name: n / max(1, len(rays)) for name, n in taken.items()}, answer


def _time_steps(tree: Tree, rays: RayBatch, radius: float, known: dict[str, float]) -> dict[str, float]:
    """Time each step alone with the instruction set in use; return the nanoseconds by name, the least so far."""
    layout = tree.layout
    now: dict[str, float] = compiled(f"_step_timings_{simd()}").time_steps(
        layout.lines.segments.reshape(-1, 6),
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
    """Import a compiled module of the benchmarks."""
    try:
        return importlib.import_module(f"fastlines_bench.{name}")
    except ImportError:
        raise InputError(
            f"fastlines-bench was built without its module {name}; install it from the repository with all "
            "instruction sets:  pip install ./benchmarks"
        ) from None


def _cell(
    scene: str, tree: Tree, rays: RayBatch, radius: float, query: str, rounds: int, alone: dict[str, float]
) -> StepCell:
    per_ray, _ = count_steps(tree, query, rays.part(COUNTED), radius)
    bound = sum(per_ray[name] * alone[name] for name in STEPS)
    again = None if rays.coherent else rays.take(np.repeat(np.arange(0, len(rays), AGAIN), AGAIN))
    best, again_ns = float("inf"), None
    for _ in range(rounds):
        best = min(best, best_of(1, 1, lambda: ask_tree(tree, query, rays, radius))[0])
        if again is not None:
            seconds, _answer = best_of(1, 1, lambda: ask_tree(tree, query, again, radius, "wave"))
            again_ns = min(again_ns or float("inf"), seconds / len(again) * 1e9)
    return StepCell(scene, radius, rays.kind, query, len(rays), per_ray, bound, best / len(rays) * 1e9, again_ns)


def print_steps(result: StepResult) -> None:
    """Print the time of each step alone, and the steps of each query."""
    console = wide_console()
    timings = new_table("a step alone: nanoseconds (cycles)", ["step"], result.alone)
    for step, meaning in STEPS.items():
        cells = [f"{alone[step]:.1f} ({alone[step] / alone['cycle']:.0f})" for alone in result.alone.values()]
        timings.add_row(meaning, *cells)
    print_table(console, timings)

    table = new_table("steps a ray, and nanoseconds", ["scene"], [])
    counted = ("bundles", "nodes", "leaves", "pieces", "lines", "packs", "tests")
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
        f"One thread, {result.machine['simd']}. sum: what the steps of a ray take alone, with nothing to wait for; "
        "stacks, packing and sorting are not in it. a ray: all there is. share: the "
        f"first of the second. again: a ray where each is asked {AGAIN} times in a row, so that all is near and hardly "
        "a guess is wrong.",
        highlight=False,
    )
