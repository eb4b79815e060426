"""Our engine and Embree, alternated on the same rays."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from fastlines import Tree, build

from ..harness import machine
from ..harness.clock import clock
from ..harness.compare import Difference, compare
from ..harness.preset import TimedPreset, sized
from ..harness.rays import KINDS, RayBatch, tiled_rays
from ..harness.subjects import Subject, tapered
from ..harness.turns import MAX_HITS, count_hits, query_tree
from ..package import num_threads
from ..peers import embree, tuning
from .result import Built, EngineCell, Result, Side

#: A trial that is shorter than this, in seconds, is repeated once.
SHORT_TRIAL = 0.1


@dataclass(frozen=True, kw_only=True)
class EnginePreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    kinds : tuple of str
        Kinds of rays: keys of `rays.KINDS`.
    method : str
        The builder of our tree.
    effort : float, optional
        The effort of "best", as in `fastlines.build`: from 0, the fastest build, to 1, the best tree.
    peer : bool
        Measure Embree too.
    trial : int
        The number of rays of a trial of all the peer's configurations, after which only the fastest are timed.
    near : float
        A configuration is timed only if its trial takes at most `near` times as long as the fastest.
    n_timed : int
        The maximum number of timed configurations. The fastest user geometry is always timed, even if it is one more.
    lengths : tuple of float
        The piece lengths that tuning tries for Embree, as fractions of the box's diagonal.
    retune : bool
        Ignore the lengths that an earlier run found.
    one_by_one : bool
        Trace each ray alone: with our kernel "single", and with Embree's rtcIntersect1.
    built_for : float, optional
        Use only user geometry for Embree, built for this radius and queried with radii no larger.
    shapes : bool
        Query round cones at the surface: lines that taper from the radius to a fifth of it along each strand, with a
        radius of 0 in the query. Embree has round linear curves.
    """

    n_rays: int = sized(1 << 20, 1 << 17)
    rounds: int = 3
    seconds: float = sized(0.4, 0.25)
    kinds: tuple[str, ...] = ("camera", "random", "ao")
    method: str = "best"
    effort: float | None = None
    peer: bool = True
    trial: int = sized(1 << 14, 1 << 12)
    n_timed: int = sized(3, 2)
    near: float = 1.25
    lengths: tuple[float, ...] = sized(tuning.LENGTHS, (0.0, 1 / 16, 1 / 64))
    retune: bool = False
    one_by_one: bool = False
    built_for: float | None = None
    shapes: bool = False


def run_engine(
    subjects: list[Subject], preset: EnginePreset, progress: Callable[[str, float], None] = lambda what, share: None
) -> Result:
    """Measure all cells of all subjects.

    Parameters
    ----------
    subjects : list of Subject
    preset : EnginePreset
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    start = time.perf_counter()
    version = embree.load(preset.n_threads) if preset.peer else None
    n_cells = sum(len(subject.radii) for subject in subjects) * len(preset.kinds)
    built: list[Built] = []
    cells: list[EngineCell] = []
    with num_threads(preset.n_threads):
        where = machine.describe(threads=preset.n_threads, embree=version)
        for subject in subjects:
            progress(f"{subject.name}: building", len(cells) / max(1, n_cells))
            runner = _Runner(subject, preset, lambda what: progress(what, len(cells) / max(1, n_cells)))
            built.append(runner.built)
            cells.extend(runner.cells())
    return Result(where, asdict(preset), built, cells, time.perf_counter() - start)


class _Runner:
    """All cells of one subject."""

    def __init__(self, subject: Subject, preset: EnginePreset, say: Callable[[str], None]) -> None:
        self.subject, self.preset, self.say = subject, preset, say
        self.now = clock(preset.n_threads)
        start = self.now()
        self.tree: Tree = build(subject.lines, preset.method, effort=preset.effort)
        seconds = self.now() - start
        start = self.now()
        n_bytes = self.tree.layout.n_bytes
        self.built = Built(subject.name, len(subject.lines), preset.method, seconds, self.now() - start, int(n_bytes))

    def cells(self) -> Iterator[EngineCell]:
        subject, preset = self.subject, self.preset
        camera = subject.rays("camera", preset.n_rays)
        fixed = {
            "camera": camera,
            "tiled": tiled_rays(subject.camera, preset.n_rays) if "tiled" in preset.kinds else camera,
            "random": subject.rays("random", preset.n_rays),
        }
        builds = self._tune(fixed) if preset.peer else {}
        for radius in subject.radii:
            if preset.shapes:
                self.tree = self.tree.refit(tapered(subject.lines, radius))
            scenes = self._scenes(radius) if preset.peer else None
            for kind in preset.kinds:
                rays = (
                    subject.occlusion_rays(self.tree, radius, preset.n_rays, 0.0 if preset.shapes else radius)
                    if kind == "ao"
                    else fixed[kind]
                )
                for query in KINDS[kind]:
                    self.say(f"{subject.name}, radius {radius:g}: {kind} rays, {query}")
                    yield self._cell(radius, rays, query, scenes, builds.get("all" if query == "all" else "first", []))

    def _scenes(self, radius: float) -> embree.Scenes:
        preset, lines, eye = self.preset, self.subject.lines, self.subject.camera.origin
        if preset.shapes:
            return embree.Scenes(tapered(lines, radius), 0.0, eye, preset.n_threads)
        return embree.Scenes(lines, radius, eye, preset.n_threads, preset.built_for)

    def _tune(self, fixed: dict[str, RayBatch]) -> dict[str, list[embree.Build]]:
        """Find the fastest builds of Embree for these lines, with the median radius."""
        subject, preset = self.subject, self.preset
        scenes = self._scenes(preset.built_for or subject.middle_radius)
        batches = [fixed[kind].part(preset.trial) for kind in ("camera", "random")]
        found = tuning.tuned_builds(
            tapered(subject.lines, subject.middle_radius) if preset.shapes else subject.lines,
            scenes,
            batches,
            ("first", "all"),
            lengths=preset.lengths,
            variants=[embree.Build("round")] if preset.shapes else tuning.VARIANTS,
            retune=preset.retune,
            progress=lambda what: self.say(f"{subject.name}: {what}"),
        )
        whole = embree.Build("round" if preset.shapes else "user")
        return {query: list(dict.fromkeys([*builds, whole])) for query, builds in found.items()}

    def _cell(
        self,
        radius: float,
        rays: RayBatch,
        query: str,
        scenes: embree.Scenes | None,
        builds: list[embree.Build],
    ) -> EngineCell:
        preset = self.preset

        # Time a trial of all configurations.
        few = rays.part(preset.trial)
        our_seconds, our_answer = self._time(partial(self._query, radius, query), few)
        tried: dict[embree.Config, tuple[float, Difference]] = {}
        if scenes is not None:
            for config in embree.configs(scenes, builds, query, few, preset.one_by_one):
                scenes.get(config.build)  # built before the clock runs
                seconds, answer = self._time(partial(scenes.query, config, query), few)
                if seconds < SHORT_TRIAL:
                    seconds = min(seconds, self._time(partial(scenes.query, config, query), few)[0])
                tried[config] = seconds, compare(query, our_answer, answer)
        fastest = sorted(tried, key=lambda config: tried[config][0])
        near = [config for config in fastest if tried[config][0] <= preset.near * tried[fastest[0]][0]][
            : preset.n_timed
        ]
        exact = next((config for config in fastest if config.build.geometry == "user"), None)
        near = list(dict.fromkeys([*near, *([exact] if exact else [])]))

        # Alternate both sides on as many rays as there is time for.
        slowest = max(our_seconds, *(tried[config][0] for config in near)) if near else our_seconds
        n_rays = max(len(few), int(len(few) * preset.seconds / max(slowest, 1e-6)))
        many = rays.part(n_rays)
        parts = many.slices(int(MAX_HITS / max(1.0, len(our_answer) / len(few)))) if query == "all" else [many]
        ours, n_hits, times = np.inf, 0, dict.fromkeys(near, np.inf)
        differences = dict.fromkeys(near, Difference())
        for i_round in range(preset.rounds):
            mine, theirs = 0.0, dict.fromkeys(near, 0.0)
            for part in parts:
                seconds, our_answer = self._time(partial(self._query, radius, query), part)
                mine += seconds
                if i_round == 0:
                    n_hits += count_hits(query, our_answer)
                for config in near:
                    assert scenes is not None
                    seconds, answer = self._time(partial(scenes.query, config, query), part)
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
                    preset.rounds if timed else 0,
                    scenes.build_seconds(config.build),
                    scenes.get(config.build).bytes,
                    differences[config] if timed else tried[config][1],
                )
            )
        rate = len(many) / max(ours, 1e-9) / 1e6
        return EngineCell(self.subject.name, radius, rays.kind, query, len(many), n_hits, rate, sides)

    def _query(self, radius: float, query: str, rays: RayBatch) -> Any:
        kernel = "single" if self.preset.one_by_one else "auto"
        if self.preset.shapes:
            return query_tree(self.tree, query, rays, 0.0, kernel, "surface")
        return query_tree(self.tree, query, rays, radius, kernel)

    def _time(self, answer_to: Callable[[RayBatch], Any], rays: RayBatch) -> tuple[float, Any]:
        start = self.now()
        answer = answer_to(rays)
        return self.now() - start, answer
