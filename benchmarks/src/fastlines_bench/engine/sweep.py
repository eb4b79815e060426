"""A sweep of the radius: our one tree for all radii, beside Embree, which is built anew for each.

For each radius, both sides find the first hits of a picture. Ours is one build with its layout, and the queries.
Embree's boxes contain the radius, so its time is a build and a query for each. Its configuration is the one of each
geometry that takes least on a few of the radii, builds included.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

from fastlines import FastlinesError, build
from fastlines.rendering import spaced_radii

from ..harness import machine
from ..harness.clock import clock
from ..harness.compare import compare
from ..harness.internals import num_threads
from ..harness.preset import TimedPreset, sized
from ..harness.rays import RayBatch, camera_rays
from ..harness.subjects import Subject
from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from ..harness.turns import query_tree
from ..peers.embree import Build, Config, Scenes, configs

#: The tried builds of Embree: the geometry, the longest piece in diagonals of the box (0 = whole), and the quality.
GEOMETRIES, PIECES, QUALITIES = ("user", "flat", "round"), (0.0, 1 / 8, 1 / 32), ("medium", "high")
#: How many rays choose among them.
TRIED = 1 << 13
#: At most this fraction of the rays may have another first hit in user geometry: those at the very edge of the radius.
MAX_DIFFER = 1e-3


@dataclass(frozen=True, kw_only=True)
class SweepPreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    method : str
        The builder of our tree.
    first, last : float
        The least and the largest radius.
    n_radii : int
        The number of radii, each the same factor larger.
    """

    n_rays: int = sized(512 * 512, 64 * 64)
    rounds: int = sized(3, 1)
    method: str = "best"
    first: float = 0.0005
    last: float = 0.05
    n_radii: int = sized(60, 5)


@dataclass(frozen=True)
class Side:
    """The times of one side.

    Attributes
    ----------
    name : str
        "fastlines", or Embree's configuration.
    build_s : list of float
        Seconds of each build: one of ours with its layout, one for each radius of Embree's.
    query_s : list of float
        Seconds of the query of each radius.
    """

    name: str
    build_s: list[float]
    query_s: list[float]

    @property
    def total_s(self) -> float:
        """The seconds of all builds and queries."""
        return sum(self.build_s) + sum(self.query_s)


@dataclass(frozen=True)
class SweepResult:
    """The sweep of one scene.

    Attributes
    ----------
    sides : list of Side
        Ours first; of each side the round with the least total.
    hit : list of float
        The fraction of the rays that hit, for each radius.
    differ : float or None
        The largest fraction of rays, over the radii, whose first hit in Embree's user geometry differs from ours.
    """

    machine: dict[str, Any]
    preset: SweepPreset
    scene: str
    n_prims: int
    n_rays: int
    radii: list[float]
    sides: list[Side]
    hit: list[float]
    differ: float | None

    def ratio(self, side: Side) -> float:
        """Return how many times our total another side takes."""
        return side.total_s / self.sides[0].total_s

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        ratios = {side.name: self.ratio(side) for side in self.sides[1:]}
        totals = {side.name: side.total_s for side in self.sides}
        return {"format": "fastlines-bench sweep 1", **asdict(self), "total_s": totals, "ratios": ratios}


def run_sweep(
    subject: Subject,
    preset: SweepPreset,
    with_embree: bool,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> SweepResult:
    """Time the sweep of both sides in turn, and compare their answers.

    Parameters
    ----------
    subject : Subject
        Its radii are not used.
    preset : SweepPreset
    with_embree : bool
        Whether Embree is measured too.
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    radii = spaced_radii(preset.first, preset.last, preset.n_radii)
    rays = camera_rays(subject.camera, preset.n_rays)
    chosen: list[Config] = []
    if with_embree:
        for i, geometry in enumerate(GEOMETRIES):
            progress(f"{subject.name}: choosing {geometry}", 0.3 * i / len(GEOMETRIES))
            chosen.append(_choose(subject, geometry, radii, rays, preset.n_threads))
    best: dict[str, Side] = {}
    hit: list[float] = []
    differ: float | None = None
    for i_round in range(preset.rounds):
        done = 0.3 + 0.7 * i_round / preset.rounds
        progress(f"{subject.name}: fastlines", done)
        ours, answers = _ours(subject, preset, radii, rays)
        hit = [float(answer.hit.mean()) for answer in answers]
        _keep(best, ours)
        for config in chosen:
            progress(f"{subject.name}: Embree, {config}", done)
            theirs, others = _embree(subject, config, radii, rays, preset.n_threads)
            _keep(best, theirs)
            if config.build.geometry == "user":
                pairs = zip(answers, others, strict=True)
                differ = max(compare("first", mine, other).share for mine, other in pairs)
    if differ is not None and differ > MAX_DIFFER:
        raise FastlinesError(f"first hits of {differ:.2%} of the rays differ between fastlines and Embree")
    sides = list(best.values())
    about = machine.describe(threads=preset.n_threads)
    return SweepResult(about, preset, subject.name, len(subject.lines), len(rays), radii, sides, hit, differ)


def _keep(best: dict[str, Side], side: Side) -> None:
    if side.name not in best or side.total_s < best[side.name].total_s:
        best[side.name] = side


def _ours(subject: Subject, preset: SweepPreset, radii: list[float], rays: RayBatch) -> tuple[Side, list[Any]]:
    """Build once, and query with each radius."""
    now = clock(preset.n_threads)
    with num_threads(preset.n_threads):
        start = now()
        tree = build(subject.lines, preset.method)
        tree.layout  # noqa: B018
        build_s, query_s, answers = now() - start, [], []
        for radius in radii:
            start = now()
            answers.append(query_tree(tree, "first", rays, radius))
            query_s.append(now() - start)
    return Side("fastlines", [build_s], query_s), answers


def _embree(
    subject: Subject, config: Config, radii: list[float], rays: RayBatch, n_threads: int
) -> tuple[Side, list[Any]]:
    """Build and query for each radius."""
    now = clock(n_threads)
    side, answers = Side(f"Embree, {config}", [], []), []
    for radius in radii:
        scenes = Scenes(subject.lines, radius, subject.camera.origin, n_threads)
        side.build_s.append(scenes.build_seconds(config.build))
        start = now()
        answers.append(scenes.query(config, "first", rays))
        side.query_s.append(now() - start)
    return side, answers


def _choose(subject: Subject, geometry: str, radii: list[float], rays: RayBatch, n_threads: int) -> Config:
    """Return the configuration that takes least for the first, the middle and the last radius, builds included.

    Queries of a part of the rays stand for all of them.
    """
    now, few = clock(n_threads), rays.part(TRIED)
    seconds: dict[Config, float] = {}
    for radius in (radii[0], radii[len(radii) // 2], radii[-1]):
        for share, quality in product(PIECES, QUALITIES):
            each = Build(geometry, share * subject.diagonal, quality=quality)
            scenes = Scenes(subject.lines, radius, subject.camera.origin, n_threads)
            build_s = scenes.build_seconds(each)
            for config in configs(scenes, [each], "first", few):
                start = now()
                scenes.query(config, "first", few)
                query_s = (now() - start) * len(rays) / len(few)
                seconds[config] = seconds.get(config, 0.0) + build_s + query_s
    return min(seconds, key=lambda config: seconds[config])


def print_sweep(result: SweepResult) -> None:
    """Print a table of both sides, and the ratios."""
    console = wide_console()
    title = f"{result.scene}: {len(result.radii)} radii, {result.radii[0]:g} to {result.radii[-1]:g}; "
    title += f"first hits of {result.n_rays:,} rays with each"
    table = new_table(title, ["side"], ["builds", "build s", "query s", "total s", "ratio"])
    for side in result.sides:
        seconds = (sum(side.build_s), sum(side.query_s), side.total_s)
        ratio = "" if side is result.sides[0] else f"{result.ratio(side):.2f}"
        table.add_row(side.name, str(len(side.build_s)), *map(format_3_digits, seconds), ratio)
    print_table(console, table)
    console.print(f"rays that hit: {result.hit[0]:.1%} to {result.hit[-1]:.1%}")
    if result.differ is not None:
        console.print(f"differ: {result.differ:.4%} of the rays at most, in user geometry")
        fastest = min(result.sides[1:], key=lambda side: side.total_s)
        console.print(f"Embree's fastest takes {result.ratio(fastest):.2f} times our time")
