"""Our engine and Embree, alternated on the same rays."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..builder import build
from ..camera import Camera
from ..demo.machine import describe_machine, load
from ..lines import Lines
from ..methods import METHODS
from ..scenes import RADII
from ..threads import num_threads
from ..tree import Tree
from . import embree, tuning
from .compare import Difference, compare
from .rays import KINDS, RayBatch, ao_rays, camera_rays, random_rays, tiled_rays
from .result import Built, Cell, Result, Side
from .timing import clock

__all__ = ["Case", "Cell", "Plan", "Result", "Side", "run_engine"]

#: About so many hits are asked for at a time.
MAX_HITS = 1 << 22

#: A trial that takes less than so many seconds is made twice.
TWICE = 0.1


@dataclass(frozen=True)
class Case:
    """Lines to measure, with a camera that shows them and the radii to ask with."""

    name: str
    lines: Lines
    camera: Camera
    radii: tuple[float, ...] = tuple(RADII.values())


def default_method() -> str:
    """The tree that is meant for queries."""
    return "best" if "best" in METHODS else "bvh-d2"


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Parameters
    ----------
    kinds : tuple of str
        Kinds of rays, of `rays.KINDS`.
    n_rays : int
        At most so many rays in a cell.
    n_threads : int
        Of both sides, in building and in asking.
    method : str
        Which tree of ours.
    effort : float, optional
        Of "best", as in `fastlines.build`: from 0, the fastest build, to 1, the best tree.
    peer : bool
        Measure Embree too.
    rounds : int
        Both sides take turns so often; the best time counts.
    seconds : float
        About so long may one turn of the slower side take; fewer rays are asked if all would take longer.
    trial : int
        All of the peer's configurations are tried on so many rays; those that come near the best are timed.
    near : float
        Near is to take at most so many times as long as the best,
    n_timed : int
        and to be one of so many; the best user geometry is timed in any case.
    lengths : tuple of float
        To what shares of the box's diagonal segments are cut for Embree in tuning.
    retune : bool
        Do not use the lengths that an earlier run found.
    one_by_one : bool
        Each ray is searched alone: by our kernel "single", and by Embree's rtcIntersect1.
    built_for : float, optional
        Embree is user geometry that is built for this radius and asked with others, no larger.
    """

    kinds: tuple[str, ...] = ("camera", "random", "ao")
    n_rays: int = 1 << 20
    n_threads: int = 1
    method: str = ""
    effort: float | None = None
    peer: bool = True
    rounds: int = 3
    seconds: float = 0.4
    trial: int = 1 << 14
    n_timed: int = 3
    near: float = 1.25
    lengths: tuple[float, ...] = tuning.LENGTHS
    retune: bool = False
    one_by_one: bool = False
    built_for: float | None = None


#: Ends in less than a minute, with two small scenes and one radius.
QUICK = Plan(n_rays=1 << 17, rounds=3, seconds=0.25, trial=1 << 12, n_timed=2, lengths=(0.0, 1 / 16, 1 / 64))


def run_engine(
    cases: list[Case], plan: Plan, progress: Callable[[str, float], None] = lambda what, share: None
) -> Result:
    """Measure all cells of all cases.

    Parameters
    ----------
    cases : list of Case
    plan : Plan
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    start = time.perf_counter()
    plan = replace(plan, method=plan.method or default_method())
    version = embree.load(plan.n_threads) if plan.peer else None
    n_cells = sum(len(case.radii) for case in cases) * len(plan.kinds)
    built: list[Built] = []
    cells: list[Cell] = []
    with num_threads(plan.n_threads):
        machine = {**describe_machine(), "threads": plan.n_threads, "embree": version, "load": load()}
        for case in cases:
            progress(f"{case.name}: building", len(cells) / max(1, n_cells))
            runner = _Runner(case, plan, lambda what: progress(what, len(cells) / max(1, n_cells)))
            built.append(runner.built)
            cells.extend(runner.cells())
    return Result(machine, asdict(plan), built, cells, time.perf_counter() - start)


class _Runner:
    """All cells of one case."""

    def __init__(self, case: Case, plan: Plan, say: Callable[[str], None]) -> None:
        self.case, self.plan, self.say = case, plan, say
        self.now = clock(plan.n_threads)
        start = self.now()
        self.tree: Tree = build(case.lines, plan.method, effort=plan.effort)
        seconds = self.now() - start
        start = self.now()
        n_bytes = self.tree.layout.n_bytes
        self.built = Built(case.name, len(case.lines), plan.method, seconds, self.now() - start, int(n_bytes))

    def cells(self) -> Iterator[Cell]:
        case, plan = self.case, self.plan
        camera = camera_rays(case.camera, plan.n_rays)
        fixed = {
            "camera": camera,
            "tiled": tiled_rays(case.camera, plan.n_rays) if "tiled" in plan.kinds else camera,
            "random": random_rays(case.lines, plan.n_rays),
        }
        builds = self._tune(fixed) if plan.peer else {}
        for radius in case.radii:
            scenes = self._scenes(radius) if plan.peer else None
            for kind in plan.kinds:
                rays = occlusion(case, self.tree, radius, plan.n_rays) if kind == "ao" else fixed[kind]
                for query in KINDS[kind]:
                    self.say(f"{case.name}, radius {radius:g}: {kind} rays, {query}")
                    yield self._cell(radius, rays, query, scenes, builds.get("all" if query == "all" else "first", []))

    def _scenes(self, radius: float) -> embree.Scenes:
        plan = self.plan
        return embree.Scenes(self.case.lines, radius, self.case.camera.origin, plan.n_threads, plan.built_for)

    def _tune(self, fixed: dict[str, RayBatch]) -> dict[str, list[embree.Build]]:
        """Find how Embree likes these lines best, with the middle one of the radii."""
        case, plan = self.case, self.plan
        radius = sorted(case.radii)[len(case.radii) // 2]
        scenes = self._scenes(plan.built_for or radius)
        batches = [fixed[kind].part(plan.trial) for kind in ("camera", "random")]
        found = tuning.tuned_builds(
            case.lines,
            scenes,
            batches,
            ("first", "all"),
            lengths=plan.lengths,
            retune=plan.retune,
            progress=lambda what: self.say(f"{case.name}: {what}"),
        )
        whole = embree.Build("user")
        return {query: list(dict.fromkeys([*builds, whole])) for query, builds in found.items()}

    def _cell(
        self,
        radius: float,
        rays: RayBatch,
        query: str,
        scenes: embree.Scenes | None,
        builds: list[embree.Build],
    ) -> Cell:
        plan = self.plan

        # Try everything on few rays.
        few = rays.part(plan.trial)
        our_seconds, our_answer = self._time(partial(self._ask, radius, query), few)
        tried: dict[embree.Config, tuple[float, Difference]] = {}
        if scenes is not None:
            for config in embree.configs(scenes, builds, query, few, plan.one_by_one):
                scenes.get(config.build)  # built before the clock runs
                seconds, answer = self._time(partial(scenes.ask, config, query), few)
                if seconds < TWICE:
                    seconds = min(seconds, self._time(partial(scenes.ask, config, query), few)[0])
                tried[config] = seconds, compare(query, our_answer, answer)
        fastest = sorted(tried, key=lambda config: tried[config][0])
        near = [config for config in fastest if tried[config][0] <= plan.near * tried[fastest[0]][0]][: plan.n_timed]
        exact = next((config for config in fastest if config.build.geometry == "user"), None)
        near = list(dict.fromkeys([*near, *([exact] if exact else [])]))

        # Then both sides in turn, on as many rays as there is time for.
        slowest = max(our_seconds, *(tried[config][0] for config in near)) if near else our_seconds
        n_rays = max(len(few), int(len(few) * plan.seconds / max(slowest, 1e-6)))
        many = rays.part(n_rays)
        parts = many.slices(int(MAX_HITS / max(1.0, len(our_answer) / len(few)))) if query == "all" else [many]
        ours, n_hits, times = np.inf, 0, dict.fromkeys(near, np.inf)
        differences = dict.fromkeys(near, Difference())
        for i_round in range(plan.rounds):
            mine, theirs = 0.0, dict.fromkeys(near, 0.0)
            for part in parts:
                seconds, our_answer = self._time(partial(self._ask, radius, query), part)
                mine += seconds
                if i_round == 0:
                    n_hits += count_hits(query, our_answer)
                for config in near:
                    assert scenes is not None
                    seconds, answer = self._time(partial(scenes.ask, config, query), part)
                    theirs[config] += seconds
                    if i_round == 0:
                        differences[config] += compare(query, our_answer, answer)
            ours = min(ours, mine)
            times = {config: min(times[config], theirs[config]) for config in near}

        sides = []
        for config in fastest:
            assert scenes is not None
            timed = config in times
            n, seconds = (len(many), times[config]) if timed else (len(few), tried[config][0])
            sides.append(
                Side(
                    config,
                    n / max(seconds, 1e-9) / 1e6,
                    n,
                    plan.rounds if timed else 0,
                    scenes.build_seconds(config.build),
                    scenes.get(config.build).bytes,
                    differences[config] if timed else tried[config][1],
                )
            )
        rate = len(many) / max(ours, 1e-9) / 1e6
        return Cell(self.case.name, radius, rays.kind, query, len(many), n_hits, rate, sides)

    def _ask(self, radius: float, query: str, rays: RayBatch) -> Any:
        return ask_tree(self.tree, query, rays, radius, "single" if self.plan.one_by_one else "auto")

    def _time(self, ask: Callable[[RayBatch], Any], rays: RayBatch) -> tuple[float, Any]:
        start = self.now()
        answer = ask(rays)
        return self.now() - start, answer


def occlusion(case: Case, tree: Tree, radius: float, n_rays: int) -> RayBatch:
    """Ambient-occlusion rays from what the case's camera sees."""
    small = camera_rays(case.camera, min(n_rays, 1 << 16))
    return ao_rays(case.lines, small, tree.first_hit(small.origins, small.directions, radius).t, radius, n_rays)


def ask_tree(tree: Tree, query: str, rays: RayBatch, radius: float, kernel: str = "auto") -> Any:
    """Ask our tree a query, "first", "any" or "all"."""
    ask: Any = {"first": tree.first_hit, "any": tree.any_hit, "all": tree.all_hits}[query]
    return ask(rays.origins, rays.directions, radius, t_min=rays.t_min, t_max=rays.t_max, kernel=kernel)


def count_hits(query: str, answer: Any) -> int:
    """How many hits there are, or how many rays that hit."""
    if query == "all":
        return len(answer)
    return int(answer.hit.sum() if query == "first" else answer.sum())
