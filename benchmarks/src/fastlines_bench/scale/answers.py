"""The answers of forests beside those of one tree: every query, bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from operator import methodcaller as call
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.figures import Figures
from ..harness.findings import Check
from ..harness.rays import rays_through
from ..harness.subjects import Subject, scene_subject, tapered
from .questions import columns_of, same

#: Queries a tree or a forest, and returns the answer.
Ask = Callable[[Any], Any]


def questions(subject: Subject, lines: fl.Lines, n_rays: int) -> Iterator[tuple[str, Ask]]:
    """Yield the name and the call of every query."""
    size, n_few = subject.diagonal, max(64, n_rays // 16)
    rays = rays_through(lines.bounds, n_rays, 5)
    all_rays, few_rays = ((array[:n] for array in (rays.origins, rays.directions)) for n in (n_rays, n_few))
    many, few = tuple(all_rays), tuple(few_rays)
    rng = np.random.default_rng([6, 33])
    low, high = lines.bounds.astype(np.float64)
    points = low + rng.random((n_rays, 3)) * (high - low)
    for letter, radius in subject.by_letter.items():
        yield f"first_hit, {letter}", call("first_hit", *many, radius)
        yield f"first_hit at the surface, {letter}", call("first_hit", *many, radius, at="surface")
        yield f"any_hit, {letter}", call("any_hit", *many, radius)
        yield f"count_hits, {letter}", call("count_hits", *many, radius)
        yield f"all_hits, {letter}", call("all_hits", *few, radius)
        yield f"all_hits by strand, {letter}", call("all_hits", *few, radius, at="surface", merge="strand")
        yield f"next_hits, {letter}", call("next_hits", *many, radius, k=3)
        yield f"within, {letter}", call("within", points[:n_few], 4 * radius)
        yield f"count_within, {letter}", call("count_within", points, 4 * radius)
    radius = subject.middle_radius
    ignored = rng.integers(0, len(lines), size=(n_few, 3))
    yield "first_hit with a spread", call("first_hit", *many, radius, spread=0.001)
    yield "all_hits with a spread", call("all_hits", *few, radius / 4, spread=0.0005)
    yield "first_hit between bounds", call("first_hit", *many, radius, t_min=0.3 * size, t_max=1.2 * size)
    yield "first_hit, primitives ignored", call("first_hit", *few, radius, ignore=ignored)
    yield "next_hits by distance", call("next_hits", *few, radius, k=2, rank="distance")
    yield "nearest", call("nearest", points)
    yield "nearest 5", call("nearest", points[:n_few], k=5, max_distance=0.1 * size)
    yield "pairs", call("pairs", radius / 8, skip_neighbours=2)
    yield "along", call("along", points[:5], radius)
    yield "in_box", call("in_box", points[:n_few] - 0.01 * size, points[:n_few] + 0.01 * size)


def run_answers(
    scenes: tuple[str, ...], n_segments: int | None, tiles: tuple[int, ...], n_rays: int, progress: Any
) -> Figures:
    """Query forests of each scene, of thin and of thick lines, and compare each answer with that of one tree."""
    rows, n_wrong = [], 0
    for i, name in enumerate(scenes):
        subject = scene_subject(name, n_segments)
        for lines in (subject.lines, tapered(subject.lines, subject.middle_radius)):
            tree = fl.build(lines)
            asked = dict(questions(subject, lines, n_rays))
            answers = {what: columns_of(ask(tree)) for what, ask in asked.items()}
            for k in tiles:
                progress(f"answers: {name}, {k} tiles", i / len(scenes))
                with TemporaryDirectory(prefix="fastlines-bench-") as folder:
                    wrong = _wrong(Path(folder) / "forest", lines, k, asked, answers)
                what = "thick" if lines.radius is not None else "thin"
                rows.append(
                    (name, what, len(lines), wrong[0], len(asked) + wrong[1], len(wrong[2]), ", ".join(wrong[2]))
                )
                n_wrong += len(wrong[2])
    heads = ("scene", "lines", "segments", "tiles", "answers", "different", "which")
    notes = [
        f"{n_rays:,} rays and points for each query, a sixteenth of them for lists. After each forest one of its tiles "
        "is built again by another method, and first hits are compared once more."
    ]
    checks = [Check("answers that differ from those of one tree", float(n_wrong), 0.0, scene="all scenes")]
    return Figures("answers", "the answers of forests, beside those of one tree", heads, rows, notes, checks)


def _wrong(
    folder: Path, lines: fl.Lines, n_tiles: int, asked: dict[str, Ask], answers: dict[str, Any]
) -> tuple[int, int, list[str]]:
    """Build a forest; return its number of tiles, how many more answers were compared, and what differs."""
    forest = fl.build_forest(iter([replace(lines)]), folder, max_segments=most_segments(len(lines), n_tiles))
    wrong = [what for what, ask in asked.items() if not same(answers[what], columns_of(ask(forest)))]
    forest.rebuild(forest.n_tiles // 2, method="bvh-cl")
    again = [what for what in asked if what.startswith(("first_hit", "nearest"))]
    fresh = fl.Forest(folder)
    wrong += [
        f"{what} after a tile is built again"
        for what in again
        if not same(answers[what], columns_of(asked[what](fresh)))
    ]
    return forest.n_tiles, len(again), wrong


def most_segments(n_segments: int, n_tiles: int) -> int:
    """Return the size of a tile with which a forest has about so many tiles: a build fills them to 95 %."""
    return max(1, -(-n_segments * 20 // (19 * n_tiles)))
