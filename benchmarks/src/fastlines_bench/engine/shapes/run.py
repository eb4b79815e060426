"""Shapes of ours and of Embree, alternated on the same rays."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial

from fastlines import FastlinesError

from ...harness import machine
from ...harness.clock import clock
from ...harness.compare import compare_surfaces
from ...harness.internals import num_threads
from ...harness.rays import KINDS
from ...peers import embree
from ..contest import Contest
from ..preset import EnginePreset
from ..result import EngineCell
from .result import Missing, Result, ShapeBuilt, ShapeCell
from .subjects import Ours, ShapeSubject


def run_shapes(
    subjects: list[ShapeSubject],
    preset: EnginePreset,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Result:
    """Measure all cells of all subjects.

    What fastlines cannot build or query is named in the result, with its error.
    """
    start = time.perf_counter()
    version = embree.load(preset.n_threads) if preset.peer else None
    built: list[ShapeBuilt] = []
    missing: list[Missing] = []
    cells: list[ShapeCell] = []
    with num_threads(preset.n_threads):
        where = machine.describe(threads=preset.n_threads, embree=version)
        for i, subject in enumerate(subjects):
            where_is = f"{subject.shape}, {subject.name}, radius {subject.radius:.3g}"
            say = partial(_say, progress, where_is, i / len(subjects))
            say("building")
            try:
                ours = _build(subject, preset, built)
            except FastlinesError as error:
                missing.append(Missing(subject.shape, subject.name, subject.radius, str(error)))
                continue
            cells.extend(_cells(subject, ours, preset, say))
    return Result(where, asdict(preset), built, missing, cells, time.perf_counter() - start)


def _say(progress: Callable[[str, float], None], where: str, share: float, what: str) -> None:
    progress(f"{where}: {what}", share)


def _build(subject: ShapeSubject, preset: EnginePreset, built: list[ShapeBuilt]) -> Ours:
    """Build our tree and its layout, query it once, and append the figures."""
    now = clock(preset.n_threads)
    start = now()
    ours = subject.build(preset)
    seconds = now() - start
    start = now()
    n_bytes = int(ours.tree.layout.n_bytes)
    layout_s = now() - start
    few = subject.rays("random", 1)
    for query in ours.queries.values():
        query("first", few)
        query("all", few)
    n_prims = len(ours.tree.geometry)
    place = (subject.shape, subject.name, subject.radius, subject.n_shapes)
    built.append(ShapeBuilt(*place, n_prims, seconds, layout_s, n_bytes, ours.note))
    return ours


def _cells(subject: ShapeSubject, ours: Ours, preset: EnginePreset, say: Callable[[str], None]) -> Iterator[ShapeCell]:
    contest = Contest(preset, clock(preset.n_threads))
    scenes = subject.scenes(preset.n_threads) if preset.peer else None
    batches = [subject.rays(kind, preset.n_rays).part(preset.trial) for kind in ("camera", "random")]
    builds = subject.builds(preset, batches, say) if preset.peer else {}
    differ = partial(compare_surfaces, tolerance=subject.tolerance, owner=ours.owner)
    for kind in preset.kinds:
        rays = subject.rays(kind, preset.n_rays)
        for query in KINDS[kind]:
            say(f"{kind} rays, {query}")
            own = {name: partial(answer_to, query) for name, answer_to in ours.queries.items()}
            found = contest.run(rays, query, own, scenes, builds.get(query, []), differ)
            yield ShapeCell(subject.shape, EngineCell(subject.name, subject.radius, kind, query, *found))
