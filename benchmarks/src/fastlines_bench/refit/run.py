"""The speed of refits to moving segments, and of queries on refitted trees compared with rebuilt trees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from fastlines import Lines, Tree, build

from ..harness import machine
from ..harness.clock import best_of
from ..harness.internals import num_threads, own
from ..harness.preset import TimedPreset, sized
from ..harness.rays import RayBatch, random_rays
from ..harness.subjects import Subject
from ..harness.turns import query_tree


@dataclass(frozen=True, kw_only=True)
class RefitPreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    method : str
        The builder of the tree.
    angle : float
        The twist of the last frame: the degrees by which the top of a scene is rotated against its bottom.
    n_frames : int
        The number of frames, at equal steps up to that angle.
    """

    n_rays: int = sized(1 << 17, 1 << 14)
    rounds: int = sized(5, 2)
    method: str = "best"
    angle: float = 360.0
    n_frames: int = sized(6, 2)


@dataclass(frozen=True)
class RefitCell:
    """One frame of one scene.

    Attributes
    ----------
    angle : float
        The twist in degrees.
    refit_s, layout_s : float
        Seconds of a refit without layout, and the seconds that the layout adds.
    build_s : float
        Seconds of a build with its layout.
    growth : float
        `Tree.growth`: the current cost divided by the cost as built.
    to_rebuilt : float
        The current cost divided by the cost of the rebuilt tree.
    first_ns, first_rebuilt_ns, all_ns, all_rebuilt_ns : float
        Nanoseconds per ray for the first and for all hits, on the refitted and on the rebuilt tree.
    """

    scene: str
    n_prims: int
    n_refs: int
    n_nodes: int
    angle: float
    refit_s: float
    layout_s: float
    build_s: float
    growth: float
    to_rebuilt: float
    first_ns: float
    first_rebuilt_ns: float
    all_ns: float
    all_rebuilt_ns: float

    @property
    def pays_after(self) -> float:
        """The number of rays, half of them for each query, after which a rebuild pays off; inf = never."""
        lost = (self.first_ns + self.all_ns - self.first_rebuilt_ns - self.all_rebuilt_ns) / 2
        return self.build_s / lost * 1e9 if lost > 0 else float("inf")


@dataclass(frozen=True)
class RefitResult:
    """All frames of all scenes."""

    machine: dict[str, Any]
    preset: RefitPreset
    cells: list[RefitCell]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"format": "fastlines-bench refit 1", **asdict(self)}


def twisted(lines: Lines, degrees: float) -> Lines:
    """Return lines twisted about the vertical axis through their centre: the top by `degrees`, the bottom by 0."""
    low, high = lines.bounds.astype(np.float64)
    points = lines.segments.astype(np.float64)
    x, y, z = np.moveaxis(points - (low + high) / 2, -1, 0)
    angle = np.radians(degrees) * (y / ((high - low)[1] or 1.0) + 0.5)
    cos, sin = np.cos(angle), np.sin(angle)
    turned = np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1) + (low + high) / 2
    return replace(lines, segments=own(turned.astype(np.float32)))


def run_refit(
    subjects: list[Subject], preset: RefitPreset, progress: Callable[[str, float], None] = lambda what, share: None
) -> RefitResult:
    """Twist each scene, frame by frame, and time both trees, whose answers must be the same.

    Parameters
    ----------
    subjects : list of Subject
        Only the first radius of each is used.
    preset : RefitPreset
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    cells: list[RefitCell] = []
    n_cells = len(subjects) * preset.n_frames
    for subject in subjects:
        progress(f"{subject.name}: building", len(cells) / n_cells)
        full = build(subject.lines, preset.method)
        bare = full.refit(subject.lines)  # before the layout is built, so its refits build none
        full.layout  # noqa: B018
        for angle in np.linspace(0, preset.angle, preset.n_frames + 1)[1:].tolist():
            progress(f"{subject.name}: {angle:.0f} degrees", len(cells) / n_cells)
            lines = twisted(subject.lines, angle)
            with num_threads(preset.n_threads):
                cell, bare, full = _frame(subject, preset, angle, lines, bare, full)
            cells.append(cell)
    return RefitResult(machine.describe(), preset, cells)


def _frame(
    subject: Subject, preset: RefitPreset, angle: float, lines: Lines, bare: Tree, full: Tree
) -> tuple[RefitCell, Tree, Tree]:
    def timed(rounds: int, do: Callable[[], Any]) -> tuple[float, Any]:
        return best_of(rounds, preset.n_threads, do)

    def built() -> Tree:
        tree = build(lines, preset.method)
        tree.layout  # noqa: B018
        return tree

    refit_s, bare = timed(preset.rounds, lambda: bare.refit(lines))
    both_s, full = timed(preset.rounds, lambda: full.refit(lines))
    build_s, rebuilt = timed(1, built)
    rays, ns = random_rays(lines, preset.n_rays), {}
    for query in ("first", "all"):
        answers = []
        for name, tree in (("", full), ("_rebuilt", rebuilt)):
            seconds, answer = timed(preset.rounds, partial(query_tree, tree, query, rays, subject.radii[0]))
            ns[f"{query}{name}_ns"] = seconds / len(rays) * 1e9
            answers.append(answer)
        _compare(query, rays, *answers)
    cell = RefitCell(
        scene=subject.name,
        n_prims=full.n_prims,
        n_refs=full.n_refs,
        n_nodes=full.n_nodes,
        angle=angle,
        refit_s=refit_s,
        layout_s=both_s - refit_s,
        build_s=build_s,
        growth=full.growth,
        to_rebuilt=full.cost() / rebuilt.cost(),
        **ns,
    )
    return cell, bare, full


def _compare(query: str, rays: RayBatch, refitted: Any, rebuilt: Any) -> None:
    for name in ("offsets", "prim", "t", "u", "distance"):
        if query == "first" and name == "offsets":
            continue
        if not np.array_equal(getattr(refitted, name), getattr(rebuilt, name), equal_nan=name != "prim"):
            raise AssertionError(
                f"{query} hits of {len(rays)} rays: the refitted tree's {name} differ from a new one's"
            )
