"""The pages of ``demo`` and ``report``: trees over scenes or lines, measured and drawn."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

from ..atomic_write import atomic_write
from ..methods import METHOD_NOTES
from ..render import depth_picture, level_sheet, write_picture
from ..scenes import NAMES, RADII
from .document import Document, Gallery, Picture, Section, Table
from .machine import describe_machine
from .measure import QUERIES, TreeFigures, build_within, measure_tree, time_in_turn
from .page import html
from .tables import answer_points, print_trees, queries_table, trees_table

#: The folder of pictures beside the page.
IMAGES = "images"
#: The trees whose levels are drawn.
DRAWN = ("best", "bvh-d2", "kd-d2")
#: The radius of the lines behind the boxes of a tree, as a fraction of the scene's longest side.
BEHIND = 0.002


@dataclass(frozen=True)
class Preset:
    """How large a page is.

    Parameters
    ----------
    scenes : mapping of str to int or None
        The scenes of the demo with their numbers of segments; None is the thesis's number.
    size : int
        Pixels a side of the square picture whose rays are timed, at most.
    budget : float
        Seconds for one figure.
    build_limit : float
        Seconds after which a build is ended.
    picture, samples : int
        Pixels a side of the pictures, and samples a side of each pixel.
    panel, levels : int
        Pixels a side of a level's panel, and how many levels of a tree are drawn.
    methods : tuple of str
        The trees.
    """

    scenes: Mapping[str, int | None] = field(default_factory=lambda: dict.fromkeys(NAMES))
    size: int = 512
    budget: float = 0.3
    build_limit: float = 120.0
    picture: int = 880
    samples: int = 3
    panel: int = 300
    levels: int = 6
    methods: tuple[str, ...] = ("best", *(method for method in fl.METHODS if method != "best"))


#: The sizes of the thesis; takes some minutes.
FULL = Preset()

#: Small scenes; takes about half a minute on two cores.
QUICK = Preset(
    scenes={"bun-hair": 6_000, "straight-hair": 8_000, "spaghetti": 2_000, "spaghetti-2": 2_500, "photon-beams": 2_500},
    size=128,
    budget=0.03,
    build_limit=20.0,
    picture=480,
    samples=2,
    panel=200,
)


@dataclass(frozen=True)
class Subject:
    """Lines, a camera that shows them, and radii by the thesis's letters W, M, N."""

    name: str
    title: str
    lines: fl.Lines
    camera: fl.Camera
    radii: dict[str, float]


def demo_page(directory: str | os.PathLike[str], preset: Preset, *, show_progress: bool = False) -> Path:
    """Compare the trees over the five scenes, print their figures, and write a page with pictures.

    Parameters
    ----------
    directory : str or path-like
        The folder, which is made if it does not exist. Files of an earlier run are replaced.
    preset : Preset
    show_progress : bool
        Show a bar on stderr.

    Returns
    -------
    Path
        The page, ``index.html``. Beside it are ``table.json`` and the folder ``images``.

    Raises
    ------
    FastlinesError
        If two trees answer differently, or a tree is not valid.
    """
    scenes = [fl.scenes.make(name, n_segments) for name, n_segments in preset.scenes.items()]
    subjects = [Subject(scene.name, scene.title, scene.lines, scene.camera, RADII) for scene in scenes]
    lead = (
        "The five trees of Ivan Kuckir’s thesis (Prague 2013) and the default tree of fastlines, “best”, over the five "
        "scenes of the thesis: built, validated, queried and drawn."
    )
    return _write(directory, preset, "Trees over lines, side by side", lead, subjects, False, show_progress)


def report_page(
    directory: str | os.PathLike[str],
    preset: Preset,
    name: str,
    lines: fl.Lines,
    camera: fl.Camera,
    *,
    answer: bool = True,
    show_progress: bool = False,
) -> Path:
    """Compare the trees over some lines, called `name`, with the rays of a camera; see `demo_page`.

    With `answer` the page begins with which tree suits these lines.
    """
    side = float(np.ptp(lines.bounds.astype(np.float64), axis=0).max()) or 1.0
    radii = {letter: share * side for letter, share in RADII.items()}
    subject = Subject("lines", Path(name).name, lines, camera, radii)
    lead = "The five trees of Ivan Kuckir’s thesis (Prague 2013) and the default tree of fastlines over these lines."
    return _write(directory, preset, subject.title, lead, [subject], answer, show_progress)


def _write(
    directory: str | os.PathLike[str],
    preset: Preset,
    title: str,
    lead: str,
    subjects: list[Subject],
    answer: bool,
    show_progress: bool,
) -> Path:
    folder = Path(directory)
    (folder / IMAGES).mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    found: dict[str, list[TreeFigures]] = {}
    sections = []
    with _steps(len(subjects) * (len(preset.methods) + len(QUERIES) + 2 + len(DRAWN) + 1), show_progress) as step:
        for subject in subjects:
            rows, (lines_drawn, levels_drawn) = _measure(subject, preset, folder / IMAGES, step)
            found[subject.name] = rows
            print_trees(subject.title, len(subject.lines), rows)
            if answer:
                sections.append(Section("answer", "Which tree suits these lines", points=answer_points(rows)))
            radii = ", ".join(f"{letter} = {radius:.3g}" for letter, radius in subject.radii.items())
            text = f"{len(subject.lines):,} segments. Lighter is nearer. One tree serves all radii: {radii}."
            parts: list[Table | Gallery] = [lines_drawn, trees_table(rows), queries_table(rows), levels_drawn]
            sections.append(Section(subject.name, subject.title, [text], parts))

    # Write the verdicts, the machine and all figures.
    every = [row for rows in found.values() for row in rows if row.over_s is None]
    n_compared = sum(row.n_compared for row in every)
    verdicts = [
        ("✓ Answers agree: yes", f"{n_compared:,} answers of one tree equal those of another, bit for bit"),
        (f"✓ Valid trees: {len(every)} of {len(every)}", "axioms 1 to 5, the BVH or KD axiom, Theorem 4 of the thesis"),
    ]
    methods = Section("trees", "The trees", points=[(name, METHOD_NOTES[name]) for name in preset.methods])
    machine = describe_machine()
    foot = (
        f"{machine['processor']}, {machine['threads']} threads, {machine['system']}; fastlines {machine['fastlines']}, "
        f"Python {machine['python']}; {machine['date']}; {time.perf_counter() - start:.0f} s in all."
    )
    figures = {
        "format": "fastlines trees 1",
        "title": title,
        "machine": machine,
        "n_answers_compared": n_compared,
        "n_trees_valid": len(every),
        "subjects": [
            {
                "name": subject.name,
                "title": subject.title,
                "n_segments": len(subject.lines),
                "radii": subject.radii,
                "trees": [asdict(row) for row in found[subject.name]],
            }
            for subject in subjects
        ],
    }
    page = html(Document(title, lead, [*sections, methods], foot, verdicts), folder / IMAGES, embed=False)
    for file, content in (("table.json", json.dumps(figures, indent=1) + "\n"), ("index.html", page)):
        with atomic_write(folder / file) as partial:
            partial.write_text(content, encoding="utf-8")
    return folder / "index.html"


def _measure(
    subject: Subject, preset: Preset, folder: Path, step: Callable[[str], None]
) -> tuple[list[TreeFigures], list[Gallery]]:
    """Build the trees of a subject, compare and time them; draw the lines and the trees, a gallery each."""
    rows: dict[str, TreeFigures] = {}
    trees: dict[str, fl.Tree] = {}
    best = fl.build(subject.lines)
    for method in preset.methods:
        step(f"{subject.title}: build {method}")
        tree, seconds = build_within(subject.lines, method, preset.build_limit)
        if tree is None:
            rows[method] = TreeFigures(method, over_s=preset.build_limit)
            continue
        trees[method] = tree
        rows[method] = measure_tree(tree, seconds, best, subject.camera, subject.radii["M"])

    # Time the queries of all trees in turn.
    for query, letter in QUERIES:
        for kernel in ("auto", "binary") if letter == "M" else ("auto",):
            step(f"{subject.title}: {query} hits, {letter}")
            radius = subject.radii[letter]
            rates = time_in_turn(trees, query, radius, kernel, subject.camera, preset.size, preset.budget)
            for method, rate in rates.items():
                if kernel == "auto":
                    rows[method].mrays[f"{query} {letter}"] = rate
                else:
                    rows[method].as_built[query] = rate

    # Draw the levels of some trees.
    sheets = []
    for method in DRAWN:
        if method in trees:
            step(f"{subject.title}: draw {method}")
            behind = BEHIND / RADII["M"] * subject.radii["M"]
            sheet = level_sheet(trees[method], subject.camera, behind, preset.levels, preset.panel, behind=best)
            alt = f"{subject.title}: boxes of the first levels of {method}"
            sheets.append(_keep(folder, f"{subject.name}-{method}", sheet, f"The first levels of {method}", alt))

    # Draw the lines, first with the radius M.
    step(f"{subject.title}: draw")
    pictures = []
    for letter in ("M", "W", "N"):
        radius = subject.radii[letter]
        drawn = depth_picture(best, subject.camera, preset.picture, preset.picture, radius, preset.samples)
        alt = f"{subject.title} with the radius {radius:.3g}"
        pictures.append(_keep(folder, f"{subject.name}-{letter}", drawn, f"radius {letter} = {radius:.3g}", alt))
    return list(rows.values()), [
        Gallery(pictures, 2, mosaic=True),
        Gallery(sheets, 3, 300, caption="The first levels of the trees."),
    ]


def _keep(folder: Path, name: str, picture: Any, caption: str, alt: str) -> Picture:
    write_picture(folder / f"{name}.png", picture)
    return Picture(f"{name}.png", caption, alt)


@contextmanager
def _steps(n_steps: int, show: bool) -> Iterator[Callable[[str], None]]:
    """Yield what is called with the name of each step; a bar shows it if wanted."""
    if not show:
        yield lambda name: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=n_steps, completed=-1)
        yield lambda name: bar.update(task, advance=1, description=f"{name:<40}")
