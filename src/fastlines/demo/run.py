"""Running the demonstration: build, validate, time, compare, draw, write."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeAlias

from .. import scenes
from ..builder import build
from ..errors import FastlinesError
from ..progress import ProgressCallback
from ..render import depth_picture, level_sheet, write_picture
from ..scenes import RADII, Scene
from ..tree import Tree
from .machine import describe_machine
from .measure import Answers, CameraRays, Timing, measure
from .page import write_page
from .plan import Plan
from .reference import THESIS
from .result import QUERIES, Result, Row, SceneResult
from .tables import markdown, print_tables

#: Called with the name of each step; gives what a long step calls with the share of it that is done.
Step: TypeAlias = Callable[[str], ProgressCallback]

#: The radius of the lines behind the boxes of a tree.
LEVELS_RADIUS = 0.002


def run_demo(directory: str | os.PathLike[str], plan: Plan, *, show_progress: bool = False, show: bool = True) -> Path:
    """Run the demonstration and write its page, tables and pictures to a folder.

    Parameters
    ----------
    directory : str or path-like
        Made if it does not exist; files of an earlier run are replaced.
    plan : Plan
        How large it is.
    show_progress : bool
        Show a bar on stderr.
    show : bool
        Print the tables.

    Returns
    -------
    Path
        Of ``index.html``. Beside it are ``table.md``, ``table.json`` and the folder ``images``.

    Raises
    ------
    FastlinesError
        If two trees answer differently, or a tree is not valid.
    """
    folder = Path(directory)
    (folder / "images").mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    with _steps(plan, show_progress) as step:
        results = [_run_scene(folder, plan, name, step) for name in plan.scenes]
    result = Result(plan, describe_machine(), results, time.perf_counter() - start)
    (folder / "table.json").write_text(json.dumps(result.to_json(), indent=1) + "\n", encoding="utf-8")
    (folder / "table.md").write_text(markdown(result), encoding="utf-8")
    page = write_page(folder, result)
    if show:
        print_tables(result)
    return page


def _run_scene(folder: Path, plan: Plan, name: str, step: Step) -> SceneResult:
    step(f"{name}: make")
    scene = scenes.make(name, plan.scenes[name])

    # Build and check the trees.
    trees: dict[str, Tree] = {}
    costs_g, build_s, stats = {}, {}, {}
    for method in plan.methods:
        progress = step(f"{scene.title}: build {method}")
        start = time.perf_counter()
        trees[method] = build(scene.lines, method, progress=progress)
        build_s[method] = time.perf_counter() - start
        trees[method].validate()
        stats[method], costs_g[method] = trees[method].stats(), trees[method].cost(by="g")
        f, g = stats[method]["cost"], costs_g[method]
        if abs(f - g) > 1e-9 * f:
            raise FastlinesError(f"{scene.title}, {method}: f = {f!r} and g = {g!r} differ, against Theorem 1")

    # Time them, the cheapest first: its answers to all rays are what the others are compared with.
    cheapest, *_ = by_cost = sorted(trees, key=lambda method: stats[method]["cost"])
    rays = CameraRays.of(scene.camera, plan.rays)
    expected: dict[tuple[str, str], Answers] = {}
    timings: dict[str, dict[tuple[str, str], Timing]] = {method: {} for method in trees}
    n_compared = 0
    for method in by_cost:
        progress = step(f"{scene.title}: ask {method}")
        for done, (kind, radius) in enumerate(QUERIES):
            timing, answers = measure(trees[method], rays, kind, RADII[radius], plan.budget)
            reference = expected.setdefault((kind, radius), answers)
            if answers is not reference:
                what = f"{scene.title}: {kind} hits, radius {radius}"
                n_compared += compare(what, {cheapest: reference, method: answers})
            timings[method][kind, radius] = timing
            progress((done + 1) / len(QUERIES))
    rows = [
        Row(name, method, build_s[method], stats[method], costs_g[method], timings[method]) for method in plan.methods
    ]
    pictures, sheets = _draw(folder, plan, scene, trees, trees[cheapest], step)
    n_thesis = next(iter(THESIS[name].values())).n_prims
    return SceneResult(name, scene.title, len(scene.lines), n_thesis, rows, pictures, sheets, n_compared)


def compare(what: str, answers: dict[str, Answers]) -> int:
    """Refuse the answers of two trees that are not the same to the bit.

    Parameters
    ----------
    what : str
        What was asked, for the error.
    answers : dict of str to Answers
        Those of two trees, by their names.

    Returns
    -------
    int
        How many answers were compared.
    """
    (first, mine), (second, theirs) = answers.items()
    n_different, n_compared = mine.count_differences(theirs)
    if n_different:
        raise FastlinesError(
            f"{what}: {first} and {second} answer {n_different} of {n_compared} rays differently; this is a bug in "
            "fastlines, please report it"
        )
    return n_compared


def _draw(
    folder: Path, plan: Plan, scene: Scene, trees: dict[str, Tree], fastest: Tree, step: Step
) -> tuple[dict[str, str], dict[str, str]]:
    """Draw the scene with each radius and the levels of some trees; give the files' names."""
    pictures, sheets = {}, {}
    for radius, value in RADII.items():
        progress = step(f"{scene.title}: draw radius {radius}")
        size, samples = plan.picture, plan.samples
        picture = depth_picture(fastest, scene.camera, size, size, value, samples, progress)
        pictures[radius] = f"images/{scene.name}-{radius}.png"
        write_picture(folder / pictures[radius], picture)
    for method in plan.drawn:
        if method in trees:
            progress = step(f"{scene.title}: draw the levels of {method}")
            sheet = level_sheet(
                trees[method],
                scene.camera,
                LEVELS_RADIUS,
                plan.levels,
                plan.panel,
                columns=2,
                behind=fastest,
                progress=progress,
            )
            sheets[method] = f"images/{scene.name}-{method}.png"
            write_picture(folder / sheets[method], sheet)
    return pictures, sheets


@contextmanager
def _steps(plan: Plan, show: bool) -> Iterator[Step]:
    """Show which step is on, of how many; without anyone to look at it, say nothing."""
    if not show:
        yield lambda name: lambda done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    n_drawn = len(RADII) + len(set(plan.drawn) & set(plan.methods))
    n_steps = len(plan.scenes) * (1 + 2 * len(plan.methods) + n_drawn)
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=n_steps)
        begun = 0

        def step(name: str) -> ProgressCallback:
            nonlocal begun
            n_before, begun = begun, begun + 1
            bar.update(task, description=f"{name:<40}", completed=n_before)
            return lambda done: bar.update(task, completed=n_before + done)

        yield step
