"""The build times, costs and query times of each builder's tree on each scene, and their Pareto front."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ..harness import machine
from ..harness.findings import Check
from ..harness.internals import num_threads
from ..harness.preset import TimedPreset, sized
from ..harness.subjects import Subject
from ..harness.turns import TRIAL
from ..peers import embree, tuning
from .checks import checks
from .names import BUILDERS, THESIS_COST, kind_of
from .rows import BuilderRow, Over, Peer
from .trees import TimedTree, alternate_builds, alternate_queries, time_layout


@dataclass(frozen=True, kw_only=True)
class BuildersPreset(TimedPreset):
    """How much to measure.

    Parameters
    ----------
    builders : tuple of str
        Names of `BUILDERS`.
    peer : bool
        Build Embree's scenes too.
    limit : float
        Seconds for all builds of one builder on one scene; a build that exceeds it is aborted.
    lengths : tuple of float
        The piece lengths that tuning tries for Embree, as fractions of the box's diagonal.
    """

    n_rays: int = sized(1 << 18, 1 << 16)
    rounds: int = sized(5, 3)
    seconds: float = sized(1.0, 0.2)
    builders: tuple[str, ...] = tuple(BUILDERS)
    peer: bool = True
    limit: float = sized(60.0, 10.0)
    lengths: tuple[float, ...] = sized(tuning.LENGTHS, (0.0, 1 / 16, 1 / 64))


@dataclass(frozen=True)
class BuildersResult:
    """The rows of all builders and scenes, and Embree's builds."""

    machine: dict[str, Any]
    preset: BuildersPreset
    rows: list[BuilderRow]
    over: list[Over]
    peers: list[Peer]
    asked: list[dict[str, Any]]
    seconds: float

    def scenes(self) -> dict[str, list[BuilderRow]]:
        """Return the rows of each scene."""
        found: dict[str, list[BuilderRow]] = {}
        for row in self.rows:
            found.setdefault(row.scene, []).append(row)
        return found

    def checks(self) -> list[Check]:
        """Return the checks of all rows."""
        return checks(self.rows, self.peers, self.preset.n_threads)

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench builders 1",
            "machine": self.machine,
            "preset": asdict(self.preset),
            "seconds": self.seconds,
            "rows": [row.to_json() for row in self.rows],
            "over": [asdict(over) for over in self.over],
            "peers": [{**asdict(peer), "build_s": peer.build_s} for peer in self.peers],
            "asked": self.asked,
            "checks": [check.to_json() for check in self.checks()],
        }


def front(points: Sequence[tuple[float, float]]) -> list[int]:
    """Return the indices of the Pareto front of points whose coordinates are both minimised, by ascending x.

    Examples
    --------
    >>> front([(1, 9), (2, 5), (3, 6), (4, 1), (2, 5)])
    [0, 1, 3]
    """
    found: list[int] = []
    for i in sorted(range(len(points)), key=lambda i: points[i]):
        if not found or points[i][1] < points[found[-1]][1]:
            found.append(i)
    return found


def run_builders(
    subjects: list[Subject], preset: BuildersPreset, progress: Callable[[str, float], None] = lambda what, share: None
) -> BuildersResult:
    """Measure all builders on all subjects.

    Parameters
    ----------
    subjects : list of Subject
    preset : BuildersPreset
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    start = time.perf_counter()
    version = embree.load(preset.n_threads) if preset.peer else None
    found = BuildersResult({}, preset, [], [], [], [], 0.0)
    with num_threads(preset.n_threads):
        where = machine.describe(embree=version)
        for i, subject in enumerate(subjects):

            def say(what: str, name: str = subject.name, share: float = i / len(subjects)) -> None:
                progress(f"{name}: {what}", share)

            _measure(subject, preset, found, say)
    return BuildersResult(where, preset, found.rows, found.over, found.peers, found.asked, time.perf_counter() - start)


def _measure(subject: Subject, preset: BuildersPreset, found: BuildersResult, say: Callable[[str], None]) -> None:
    """Add the results of one subject."""
    peer = _EmbreeBuild(subject, preset, say) if preset.peer else None
    built = alternate_builds(
        subject.lines, preset.builders, preset.rounds, preset.limit, say, peer.build_again if peer else lambda: None
    )
    found.over.extend(Over(subject.name, name, preset.limit) for name, tree in built.items() if tree is None)
    if peer:
        found.peers.append(peer.result())
    kept = {name: tree for name, tree in built.items() if tree is not None}
    layout_s = {name: time_layout(item.tree) for name, item in kept.items()}
    trees = {name: item.tree for name, item in kept.items()}
    timings = alternate_queries(subject, trees, preset.n_rays, preset.seconds, preset.rounds, say) if trees else {}
    for question, timing in timings.items():
        asked = {"scene": subject.name, "radius": subject.middle_radius, "question": question}
        found.asked.append({**asked, "n_rays": timing.n_rays, "n_hits": timing.n_hits})
    for name, item in kept.items():
        ns = {question: timing.seconds[name] / timing.n_rays * 1e9 for question, timing in timings.items()}
        found.rows.append(_row(subject, name, item, layout_s[name], ns))


def _row(subject: Subject, name: str, built: TimedTree, layout_s: float, ns: dict[str, float]) -> BuilderRow:
    tree = built.tree
    kind = kind_of(tree.settings)
    return BuilderRow(
        subject.name,
        len(subject.lines),
        name,
        kind,
        tree.n_refs,
        tree.n_nodes,
        tree.settings.cost.c_trav,
        tree.cost(),
        tree.cost(model=THESIS_COST[kind]),
        tuple(built.seconds),
        layout_s,
        int(tree.layout.n_bytes),
        ns,
        dict(tree.limits_hit),
    )


class _EmbreeBuild:
    """Embree's build of a subject, repeated in each round."""

    def __init__(self, subject: Subject, preset: BuildersPreset, say: Callable[[str], None]) -> None:
        self.subject, self.seconds, self.bytes = subject, list[float](), 0
        self.scenes = embree.Scenes(subject.lines, subject.middle_radius, subject.camera.origin, preset.n_threads)
        batches = [rays.part(TRIAL) for rays in (subject.rays(kind, preset.n_rays) for kind in ("camera", "random"))]
        tuned = tuning.tuned_builds(
            subject.lines, self.scenes, batches, ("first", "all"), lengths=preset.lengths, progress=say
        )
        self.build = tuning.usual_build(tuned, self.scenes, batches)

    def build_again(self) -> None:
        self.bytes = self.scenes.get(self.build).bytes
        self.seconds.append(self.scenes.build_seconds(self.build))
        self.scenes.forget()

    def result(self) -> Peer:
        return Peer(self.subject.name, str(self.build), tuple(self.seconds), self.bytes)
