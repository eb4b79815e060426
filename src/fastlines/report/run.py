"""The pages of ``demo`` and ``report``: trees over scenes or lines, measured and drawn."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

from ..progress import reporting
from ..rendering import level_sheet, write_picture
from ..rendering.shading.depth_tone import grey
from ..scenes import NAMES, RADII, Scene, make
from ..settings.methods import METHOD_NOTES
from ..support.atomic_write import atomic_write
from .measure import QUERIES, TreeFigures, build_within, describe_machine, measure_tree, time_in_turn
from .page import Section, gallery, page, points
from .tables import answer_points, print_trees, queries_table, trees_table

#: What the pages compare.
TREES = "The five trees of Ivan Kuckir’s thesis (Prague 2013), and “best” and “beams” of fastlines"
#: The folder of pictures beside the page.
IMAGES = "images"
#: The trees whose levels are drawn.
DRAWN = ("best", "bvh-d2", "kd-d2")
#: The looks of the scenes, whatever their size.
LOOKS = {"bun-hair": "hair", "straight-hair": "hair", "spaghetti": "tube", "spaghetti-2": "tube"}
#: The radius of the lines behind the boxes of a tree, as a multiple of the radius M.
BEHIND = 2.0


@dataclass(frozen=True)
class Preset:
    """The size of a page."""

    #: The scenes of the demo with their numbers of segments; None is the thesis's number.
    scenes: Mapping[str, int | None] = field(default_factory=lambda: dict.fromkeys(NAMES))
    #: The most pixels a side of the square picture whose rays are timed.
    size: int = 512
    #: Seconds for one figure, and the seconds after which a build is cancelled.
    budget: float = 0.3
    build_limit: float = 120.0
    #: Pixels a side of the pictures, and samples of each pixel.
    picture: int = 880
    samples: int = 16
    #: Pixels a side of a level's panel, and how many levels of a tree are drawn.
    panel: int = 300
    levels: int = 6
    methods: tuple[str, ...] = tuple(fl.METHODS)


#: The sizes of the thesis; takes some minutes.
FULL = Preset()

#: Small scenes; takes about half a minute on two cores.
QUICK = Preset(
    scenes={"bun-hair": 6_000, "straight-hair": 8_000, "spaghetti": 2_000, "spaghetti-2": 2_500, "photon-beams": 2_500},
    size=128,
    budget=0.03,
    build_limit=20.0,
    picture=480,
    samples=8,
    panel=200,
)


def demo_page(directory: str | os.PathLike[str], preset: Preset, *, show_progress: bool = False) -> Path:
    """Compare the trees over the five scenes, print their figures, and write a page with pictures.

    The page is ``index.html`` in a folder, which is made if it does not exist; beside it are ``table.json`` and the
    folder ``images``. Files of an earlier run are replaced. A FastlinesError is raised if two trees answer differently,
    or if a tree is not valid.
    """
    scenes = [make(name, n_segments) for name, n_segments in preset.scenes.items()]
    lead = f"{TREES}, over the five scenes of the thesis: built, validated, queried and drawn."
    return _write(directory, preset, "Trees over lines, side by side", lead, scenes, RADII, False, show_progress)


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

    With `answer` the page first says which tree suits these lines.
    """
    side = float(np.ptp(lines.bounds.astype(np.float64), axis=0).max()) or 1.0
    radii = {letter: share * side for letter, share in RADII.items()}
    scene = Scene("lines", Path(name).name, lines, camera)
    lead = f"{TREES}, over these lines."
    return _write(directory, preset, scene.title, lead, [scene], radii, answer, show_progress)


def _write(
    directory: str | os.PathLike[str],
    preset: Preset,
    title: str,
    lead: str,
    scenes: Sequence[Scene],
    radii: Mapping[str, float],
    answer: bool,
    show_progress: bool,
) -> Path:
    folder = Path(directory)
    (folder / IMAGES).mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    every: list[TreeFigures] = []
    sections, subjects = [], []
    n_steps = len(scenes) * (len(preset.methods) + len(QUERIES) + 1)
    with reporting(show_progress, "trees") as callback:
        steps = Steps(n_steps, callback)
        for scene in scenes:
            rows, trees = _measure(scene, preset, radii, steps)
            every += [row for row in rows if row.over_s is None]
            what = {"name": scene.name, "title": scene.title, "n_segments": len(scene.lines), "radii": dict(radii)}
            subjects.append({**what, "trees": [asdict(row) for row in rows]})
            print_trees(scene.title, len(scene.lines), rows)
            if answer:
                sections.append(Section("answer", "Which tree suits these lines", points(answer_points(rows))))
            listed = ", ".join(f"{letter} = {radius:.3g}" for letter, radius in radii.items())
            about = f"{scene.lines.count_text()}. One tree serves all radii: {listed}. In grey, lighter is nearer."
            lines_drawn, levels_drawn = _draw(scene, preset, radii, trees, folder / IMAGES, steps)
            steps.end()
            body = [f"<p>{about}</p>", lines_drawn, trees_table(rows), queries_table(rows), levels_drawn]
            sections.append(Section(scene.name, scene.title, "\n".join(body)))

    # Write the verdicts, the machine and all figures.
    n_compared = sum(row.n_compared for row in every)
    verdicts = [
        ("✓ Answers agree: yes", f"{n_compared:,} answers of one tree equal those of another, bit for bit"),
        (f"✓ Valid trees: {len(every)} of {len(every)}", "axioms 1 to 5, the BVH or KD axiom, Theorem 4 of the thesis"),
    ]
    notes = [(name, METHOD_NOTES[name]) for name in preset.methods]
    sections.append(Section("trees", "The trees", points(notes)))
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
        "subjects": subjects,
    }
    whole = page(title, lead, sections, foot, verdicts)
    for file, content in (("table.json", json.dumps(figures, indent=1) + "\n"), ("index.html", whole)):
        with atomic_write(folder / file) as partial:
            partial.write_text(content, encoding="utf-8")
    return folder / "index.html"


class Steps:
    """Counts steps, and reports how far the current one is, so that the time that is left never stands still."""

    def __init__(self, n_steps: int, callback: Callable[[float], object] | None) -> None:
        self.n_steps, self.callback, self.done = n_steps, callback, 0

    def within(self, share: float, part: int = 0, n_parts: int = 1) -> None:
        """Report how much of the current step is done, or of one of its equal parts."""
        if self.callback is not None:
            self.callback((self.done + (part + share) / n_parts) / self.n_steps)

    def end(self) -> None:
        """End the current step."""
        self.done += 1
        self.within(0.0)


def _measure(
    scene: Scene, preset: Preset, radii: Mapping[str, float], steps: Steps
) -> tuple[list[TreeFigures], dict[str, fl.Tree]]:
    """Build the trees of a scene, compare them, and time their queries in turn."""
    rows: dict[str, TreeFigures] = {}
    trees: dict[str, fl.Tree] = {}
    best = fl.build(scene.lines)
    for method in preset.methods:
        tree, seconds = build_within(scene.lines, method, preset.build_limit, steps.within)
        if tree is None:
            rows[method] = TreeFigures(method, over_s=preset.build_limit)
        else:
            trees[method] = tree
            rows[method] = measure_tree(tree, seconds, best, scene.camera, radii["M"])
        steps.end()
    for query, letter in QUERIES:
        kernels = ("auto", "binary") if letter == "M" else ("auto",)
        for i, kernel in enumerate(kernels):
            sizes = scene.camera, preset.size, preset.budget
            watch = partial(steps.within, part=i, n_parts=len(kernels))
            rates = time_in_turn(trees, query, radii[letter], kernel, *sizes, watch)
            for method, (rate, noise) in rates.items():
                rows[method].noise.append(noise)
                if kernel == "auto":
                    rows[method].mrays[f"{query} {letter}"] = rate
                else:
                    rows[method].as_built[query] = rate
        steps.end()
    return list(rows.values()), trees


def _draw(
    scene: Scene,
    preset: Preset,
    radii: Mapping[str, float],
    trees: Mapping[str, fl.Tree],
    folder: Path,
    steps: Steps,
) -> tuple[str, str]:
    """Draw the lines, shaded with the radius M and by depth with the others, and the levels of some trees."""
    best = trees.get("best") or fl.build(scene.lines)
    pictures, sheets = [], []
    size: dict[str, Any] = {"width": preset.picture, "height": preset.picture, "samples": preset.samples}
    for i, letter in enumerate(("M", "W", "N")):
        watch = partial(steps.within, part=i, n_parts=3)
        look = LOOKS.get(scene.name) if letter == "M" else "depth"  # else the one that suits the lines
        picture = fl.render(best, scene.camera, look=look, radius=radii[letter], progress=watch, **size)
        drawn = grey(picture) if look == "depth" else picture.to_bytes()
        file, radius = f"{scene.name}-{letter}.png", f"{radii[letter]:.3g}"
        write_picture(folder / file, drawn)
        pictures.append((f"{IMAGES}/{file}", f"radius {letter} = {radius}", f"{scene.title} with the radius {radius}"))
    for method in (method for method in DRAWN if method in trees):
        behind = BEHIND * radii["M"]
        drawn = level_sheet(trees[method], scene.camera, behind, preset.levels, preset.panel, behind=best)
        file, levels = f"{scene.name}-{method}.png", f"first levels of {method}"
        write_picture(folder / file, drawn)
        sheets.append((f"{IMAGES}/{file}", f"The {levels}", f"{scene.title}: boxes of the {levels}"))
    return gallery(pictures), '<p class="note">The first levels of the trees. </p>' + gallery(sheets, 3, 300)
