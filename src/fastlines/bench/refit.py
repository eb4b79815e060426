"""How fast trees follow moving segments, and what their queries lose by it, beside trees that are built anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..backend import simd
from ..builder import build
from ..demo.machine import describe_machine
from ..immutable import own
from ..lines import Lines
from ..threads import num_threads
from ..tree import Tree
from .engine import Case, ask_tree
from .rays import RayBatch, random_rays
from .timing import clock


@dataclass(frozen=True)
class RefitPlan:
    """How much to measure.

    Parameters
    ----------
    method : str
        Which tree.
    angle : float
        By how many degrees the top of a scene is turned against its bottom in the last frame.
    n_frames : int
        How many frames, evenly spread up to it.
    n_rays : int
        So many random rays ask for their first and for all hits.
    n_threads : int
        For refits and queries; builds take one.
    rounds : int
        The best of so many times counts; of builds, the only one.
    """

    method: str = "best"
    angle: float = 360.0
    n_frames: int = 6
    n_rays: int = 1 << 17
    n_threads: int = 1
    rounds: int = 5


@dataclass(frozen=True)
class RefitCell:
    """One frame of one scene.

    Attributes
    ----------
    angle : float
        Of the twist, in degrees.
    refit_s, layout_s : float
        Seconds of a refit without layout, and of what a layout adds to it.
    build_s : float
        Seconds of a build with its layout.
    growth : float
        `Tree.growth`: cost now by cost as built.
    to_rebuilt : float
        Cost now by cost of the tree built anew.
    first_ns, first_rebuilt_ns, all_ns, all_rebuilt_ns : float
        Nanoseconds a ray for its first and for all hits, on the refitted tree and on the one built anew.
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
        """After how many rays, half of them asked for each query, a build pays; inf = never."""
        lost = (self.first_ns + self.all_ns - self.first_rebuilt_ns - self.all_rebuilt_ns) / 2
        return self.build_s / lost * 1e9 if lost > 0 else float("inf")


@dataclass(frozen=True)
class RefitResult:
    """All frames of all scenes."""

    machine: dict[str, Any]
    plan: RefitPlan
    cells: list[RefitCell]

    def to_json(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {"format": "fastlines bench refit 1", **asdict(self)}


def twisted(lines: Lines, degrees: float) -> Lines:
    """Turn lines about the vertical through their middle: the top by so much, the bottom not at all."""
    low, high = lines.bounds.astype(np.float64)
    points = lines.segments.astype(np.float64)
    x, y, z = np.moveaxis(points - (low + high) / 2, -1, 0)
    angle = np.radians(degrees) * (y / ((high - low)[1] or 1.0) + 0.5)
    cos, sin = np.cos(angle), np.sin(angle)
    turned = np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1) + (low + high) / 2
    return replace(lines, segments=own(turned.astype(np.float32)))


def run_refit(
    cases: list[Case], plan: RefitPlan, progress: Callable[[str, float], None] = lambda what, share: None
) -> RefitResult:
    """Twist each scene, frame by frame; answers of both trees must be the same.

    Parameters
    ----------
    cases : list of Case
        Of several radii the first counts.
    plan : RefitPlan
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    cells: list[RefitCell] = []
    n_cells = len(cases) * plan.n_frames
    for case in cases:
        progress(f"{case.name}: building", len(cells) / n_cells)
        laid = build(case.lines, plan.method)
        bare = laid.refit(case.lines)  # before there is a layout, so its own refits make none
        laid.layout  # noqa: B018
        for angle in np.linspace(0, plan.angle, plan.n_frames + 1)[1:].tolist():
            progress(f"{case.name}: {angle:.0f} degrees", len(cells) / n_cells)
            lines = twisted(case.lines, angle)
            with num_threads(plan.n_threads):
                cell, bare, laid = _frame(case, plan, angle, lines, bare, laid)
            cells.append(cell)
    return RefitResult({**describe_machine(), "simd": simd()}, plan, cells)


def _frame(
    case: Case, plan: RefitPlan, angle: float, lines: Lines, bare: Tree, laid: Tree
) -> tuple[RefitCell, Tree, Tree]:
    def timed(rounds: int, do: Callable[[], Any]) -> tuple[float, Any]:
        now, best, result = clock(plan.n_threads), float("inf"), None
        for _ in range(rounds):
            start = now()
            result = do()
            best = min(best, now() - start)
        return best, result

    def built() -> Tree:
        tree = build(lines, plan.method)
        tree.layout  # noqa: B018
        return tree

    refit_s, bare = timed(plan.rounds, lambda: bare.refit(lines))
    both_s, laid = timed(plan.rounds, lambda: laid.refit(lines))
    build_s, anew = timed(1, built)
    rays, ns = random_rays(lines, plan.n_rays), {}
    for query in ("first", "all"):
        answers = []
        for name, tree in (("", laid), ("_rebuilt", anew)):
            seconds, answer = timed(plan.rounds, partial(ask_tree, tree, query, rays, case.radii[0]))
            ns[f"{query}{name}_ns"] = seconds / len(rays) * 1e9
            answers.append(answer)
        _compare(query, rays, *answers)
    cell = RefitCell(
        scene=case.name,
        n_prims=laid.n_prims,
        n_refs=laid.n_refs,
        n_nodes=laid.n_nodes,
        angle=angle,
        refit_s=refit_s,
        layout_s=both_s - refit_s,
        build_s=build_s,
        growth=laid.growth,
        to_rebuilt=laid.cost() / anew.cost(),
        **ns,
    )
    return cell, bare, laid


def _compare(query: str, rays: RayBatch, refitted: Any, rebuilt: Any) -> None:
    for name in ("offsets", "prim", "t", "u", "distance"):
        if query == "first" and name == "offsets":
            continue
        if not np.array_equal(getattr(refitted, name), getattr(rebuilt, name), equal_nan=name != "prim"):
            raise AssertionError(
                f"{query} hits of {len(rays)} rays: the refitted tree's {name} differ from a new one's"
            )
