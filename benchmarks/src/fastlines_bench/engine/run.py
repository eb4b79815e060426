"""Our engine and Embree, alternated on the same rays."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial

from fastlines import Tree, build

from ..harness import machine
from ..harness.clock import clock
from ..harness.internals import num_threads
from ..harness.rays import KINDS, RayBatch, tiled_rays
from ..harness.subjects import Subject
from ..harness.turns import query_tree
from ..peers import embree, tuning
from ..peers.calls import Calls
from .contest import OURS, Answer, Contest
from .preset import EnginePreset
from .result import Built, EngineCell, Result


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
        now = clock(preset.n_threads)
        self.contest = Contest(preset, now)
        start = now()
        self.tree: Tree = build(subject.lines, preset.method, effort=preset.effort)
        seconds = now() - start
        self.calls = Calls(self.tree, preset.n_threads) if preset.one_by_one else None
        start = now()
        n_bytes = self.tree.layout.n_bytes
        self.built = Built(subject.name, len(subject.lines), preset.method, seconds, now() - start, int(n_bytes))

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
            scenes = self._scenes(radius) if preset.peer else None
            for kind in preset.kinds:
                rays = subject.occlusion_rays(self.tree, radius, preset.n_rays) if kind == "ao" else fixed[kind]
                for query in KINDS[kind]:
                    self.say(f"{subject.name}, radius {radius:g}: {kind} rays, {query}")
                    candidates = builds.get("all" if query == "all" else "first", [])
                    found = self.contest.run(rays, query, self._own(radius, query), scenes, candidates)
                    yield EngineCell(subject.name, radius, rays.kind, query, *found)

    def _scenes(self, radius: float) -> embree.Scenes:
        preset, lines, eye = self.preset, self.subject.lines, self.subject.camera.origin
        return embree.Scenes(lines, radius, eye, preset.n_threads, preset.built_for)

    def _tune(self, fixed: dict[str, RayBatch]) -> dict[str, list[embree.Build]]:
        """Find the fastest builds of Embree for these lines, with the median radius."""
        subject, preset = self.subject, self.preset
        scenes = self._scenes(preset.built_for or subject.middle_radius)
        batches = [fixed[kind].part(preset.trial) for kind in ("camera", "random")]
        found = tuning.tuned_builds(
            subject.lines,
            scenes,
            batches,
            ("first", "all"),
            lengths=preset.lengths,
            retune=preset.retune,
            progress=lambda what: self.say(f"{subject.name}: {what}"),
        )
        return {query: list(dict.fromkeys([*builds, embree.Build("user")])) for query, builds in found.items()}

    def _own(self, radius: float, query: str) -> dict[str, Answer]:
        """Return what answers a batch of rays; one by one, the library does, and the C interface takes turns."""
        if self.calls is None:
            return {OURS: partial(query_tree, self.tree, query, radius=radius)}
        return {
            OURS: partial(self.calls.query, "C++", query, radius),
            "C": partial(self.calls.query, "C", query, radius),
        }
