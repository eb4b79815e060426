"""What each builder's tree costs to build, and what that buys: scene × builder, and the front that none is beyond."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from ..demo.machine import describe_machine, load
from ..threads import num_threads
from . import embree, tuning
from .alternate import TRIAL
from .builders import BUILDERS, THESIS_COST, kind_of
from .claims import Claim, claims
from .engine import Case
from .result import geometric_mean
from .trees import Grown, ask_in_turn, build_in_turn, lay_out, middle_radius, rays_of


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Parameters
    ----------
    builders : tuple of str
        Names of `BUILDERS`.
    n_threads : int
        Of all builds, Embree's too, and of the queries.
    peer : bool
        Build Embree's scenes too.
    limit : float
        Seconds for all builds of one builder on one scene; a build that does not end within them is ended.
    n_rays : int
        At most so many rays, or a few more.
    rounds : int
        So often take all builders their turns. Of builds the median counts, of queries the best.
    seconds : float
        About so long may one turn of the slowest tree take.
    lengths : tuple of float
        To what shares of the box's diagonal segments are cut for Embree in tuning.
    """

    builders: tuple[str, ...] = tuple(BUILDERS)
    n_threads: int = 1
    peer: bool = True
    limit: float = 60.0
    n_rays: int = 1 << 18
    rounds: int = 5
    seconds: float = 1.0
    lengths: tuple[float, ...] = tuning.LENGTHS


#: Ends in a minute or two, with small scenes.
QUICK = Plan(limit=10.0, n_rays=1 << 16, rounds=3, seconds=0.2, lengths=(0.0, 1 / 16, 1 / 64))


@dataclass(frozen=True)
class Row:
    """A builder's tree over a scene.

    Attributes
    ----------
    kind : {"bvh", "kd"}
    cost : float
        With the builder's own c_trav.
    thesis_cost : float
        With that of `THESIS_COST`, the same for all trees of its kind.
    builds : tuple of float
        Seconds of each build.
    layout_s : float
        To lay it out for queries.
    bytes : int
        Of the layout and the segments.
    ns : dict of str to float
        Nanoseconds a ray, by question.
    limits_hit : dict of str to int
        As `Tree.limits_hit` has it.
    """

    scene: str
    n_segments: int
    builder: str
    kind: str
    n_refs: int
    n_nodes: int
    c_trav: float
    cost: float
    thesis_cost: float
    builds: tuple[float, ...]
    layout_s: float
    bytes: int
    ns: dict[str, float]
    limits_hit: dict[str, int]

    @property
    def build_s(self) -> float:
        """The median of all builds."""
        return median(self.builds)

    @property
    def query_ns(self) -> float:
        """Nanoseconds a ray: the geometric mean over all questions."""
        return geometric_mean(list(self.ns.values())) or 0.0

    def to_json(self) -> dict[str, Any]:
        """Everything."""
        return {**asdict(self), "build_s": self.build_s, "query_ns": self.query_ns}


@dataclass(frozen=True)
class Over:
    """A build that was ended after so many seconds."""

    scene: str
    builder: str
    seconds: float


@dataclass(frozen=True)
class Peer:
    """Embree's scene: the build whose queries are fastest, over all questions."""

    scene: str
    config: str
    builds: tuple[float, ...]
    bytes: int

    @property
    def build_s(self) -> float:
        """The median of all builds."""
        return median(self.builds)


@dataclass(frozen=True)
class Pareto:
    """All that was measured."""

    machine: dict[str, Any]
    plan: Plan
    rows: list[Row]
    over: list[Over]
    peers: list[Peer]
    asked: list[dict[str, Any]]
    seconds: float

    def scenes(self) -> dict[str, list[Row]]:
        """The rows of each scene."""
        found: dict[str, list[Row]] = {}
        for row in self.rows:
            found.setdefault(row.scene, []).append(row)
        return found

    def claims(self) -> list[Claim]:
        """What ought to hold."""
        return claims(self.rows, self.peers, self.plan.n_threads)

    def to_json(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "format": "fastlines bench pareto 1",
            "machine": self.machine,
            "plan": asdict(self.plan),
            "seconds": self.seconds,
            "rows": [row.to_json() for row in self.rows],
            "over": [asdict(over) for over in self.over],
            "peers": [{**asdict(peer), "build_s": peer.build_s} for peer in self.peers],
            "asked": self.asked,
            "claims": [claim.to_json() for claim in self.claims()],
        }


def front(points: Sequence[tuple[float, float]]) -> list[int]:
    """The points that no other is left of or below without being the other way round too, from the left.

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


def run_pareto(
    cases: list[Case], plan: Plan, progress: Callable[[str, float], None] = lambda what, share: None
) -> Pareto:
    """Measure all builders on all cases.

    Parameters
    ----------
    cases : list of Case
    plan : Plan
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    start = time.perf_counter()
    version = embree.load(plan.n_threads) if plan.peer else None
    found = Pareto({}, plan, [], [], [], [], 0.0)
    with num_threads(plan.n_threads):
        machine = {**describe_machine(), "embree": version, "load": load()}
        for i, case in enumerate(cases):
            _measure(case, plan, found, lambda what, i=i, case=case: progress(f"{case.name}: {what}", i / len(cases)))  # type: ignore[misc]
    return Pareto(machine, plan, found.rows, found.over, found.peers, found.asked, time.perf_counter() - start)


def _measure(case: Case, plan: Plan, found: Pareto, say: Callable[[str], None]) -> None:
    """Add what one case gives."""
    peer = _EmbreeBuild(case, plan, say) if plan.peer else None
    grown = build_in_turn(case.lines, plan.builders, plan.rounds, plan.limit, say, peer.again if peer else lambda: None)
    found.over.extend(Over(case.name, name, plan.limit) for name, tree in grown.items() if tree is None)
    if peer:
        found.peers.append(peer.result())
    kept = {name: tree for name, tree in grown.items() if tree is not None}
    layout_s = {name: lay_out(item.tree) for name, item in kept.items()}
    trees = {name: item.tree for name, item in kept.items()}
    turns = ask_in_turn(case, trees, plan.n_rays, plan.seconds, plan.rounds, say) if trees else {}
    for question, turn in turns.items():
        asked = {"scene": case.name, "radius": middle_radius(case), "question": question}
        found.asked.append({**asked, "n_rays": turn.n_rays, "n_hits": turn.n_hits})
    for name, item in kept.items():
        ns = {question: turn.seconds[name] / turn.n_rays * 1e9 for question, turn in turns.items()}
        found.rows.append(_row(case, name, item, layout_s[name], ns))


def _row(case: Case, name: str, grown: Grown, layout_s: float, ns: dict[str, float]) -> Row:
    tree = grown.tree
    kind = kind_of(tree.settings)
    return Row(
        case.name,
        len(case.lines),
        name,
        kind,
        tree.n_refs,
        tree.n_nodes,
        tree.settings.cost.c_trav,
        tree.cost(),
        tree.cost(model=THESIS_COST[kind]),
        tuple(grown.seconds),
        layout_s,
        int(tree.layout.n_bytes),
        ns,
        dict(tree.limits_hit),
    )


class _EmbreeBuild:
    """Embree's build of a case, made anew each round."""

    def __init__(self, case: Case, plan: Plan, say: Callable[[str], None]) -> None:
        self.case, self.seconds, self.bytes = case, list[float](), 0
        self.scenes = embree.Scenes(case.lines, middle_radius(case), case.camera.origin, plan.n_threads)
        batches = [rays.part(TRIAL) for rays in rays_of(case, plan.n_rays).values()]
        tuned = tuning.tuned_builds(
            case.lines, self.scenes, batches, ("first", "all"), lengths=plan.lengths, progress=say
        )
        self.build = tuning.usual_build(tuned, self.scenes, batches)

    def again(self) -> None:
        self.bytes = self.scenes.get(self.build).bytes
        self.seconds.append(self.scenes.build_seconds(self.build))
        self.scenes.forget()

    def result(self) -> Peer:
        return Peer(self.case.name, str(self.build), tuple(self.seconds), self.bytes)
