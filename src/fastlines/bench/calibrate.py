"""What a step takes on this machine, and which figure of a tree tells how fast it will be asked.

Two questions. How many nanoseconds do the steps of a query take: those of the search through the tree as it was built,
which the cost model is about (c_trav a step down, c_prim a test), and those of the kernels on the wide layout? And
which figure that is known before any query puts the trees of all builders in the order in which they will be fast?
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ..backend import counting, simd
from ..demo.machine import describe_machine, load
from ..settings import Cost
from ..threads import num_threads
from ..tree import Tree
from .builders import BUILDERS, kind_of
from .engine import Case, ask_tree, count_hits
from .fit import Fit, fit_steps
from .overlap import overlap
from .predict import PREDICTORS, Mix, Predictor, best_mix, predictors
from .rays import QUESTIONS
from .result import geometric_mean
from .steps import STEPS
from .trees import ask_in_turn, build_in_turn, lay_out, middle_radius, rays_of
from .visits import count_visits, expect_visits, expect_wide

#: What the tree as it was built is asked: a search for all hits visits all that it meets, in whatever order.
BINARY = ("random", "all")

#: How trees of a kind are searched as they were built.
SEARCHES = {"bvh": "binary, by boxes", "kd": "binary, by planes"}

#: The same question to the layout, explained by the steps that the tree as it was built would take.
LAYOUT = "layout, by binary steps"

#: Steps are counted on so many rays at most: by the kernels, and one node at a time.
COUNTED, WALKED = 1 << 14, 1 << 10


@dataclass(frozen=True)
class Plan:
    """How much to measure; the names are those of `pareto.Plan`."""

    builders: tuple[str, ...] = tuple(name for name, given in BUILDERS.items() if "exhaustive" not in given)
    limit: float = 20.0
    n_rays: int = 1 << 17
    rounds: int = 5
    seconds: float = 0.5


#: Ends in a minute, with small scenes.
QUICK = Plan(limit=5.0, n_rays=1 << 15, rounds=3, seconds=0.1)


@dataclass(frozen=True)
class Sample:
    """A tree, what was counted, and what was timed.

    Attributes
    ----------
    kind : str
        "bvh" or "kd".
    ns : dict of str to float
        Nanoseconds a ray, by question; "binary" is that of the search through the tree as it was built.
    steps : dict of str to dict
        Steps a ray of the kernels, by question; "binary" has inner nodes, tests and hits.
    figures : dict of str to float
        What areas and overlap say: see `predict.predictors`.
    """

    scene: str
    builder: str
    kind: str
    ns: dict[str, float]
    steps: dict[str, dict[str, float]]
    figures: dict[str, float]

    @property
    def query_ns(self) -> float:
        """Nanoseconds a ray of the kernels: the geometric mean over all questions."""
        return geometric_mean([self.ns[" ".join(question)] for question in QUESTIONS]) or 0.0

    def to_json(self) -> dict[str, Any]:
        """Everything."""
        return {**asdict(self), "query_ns": self.query_ns}


@dataclass(frozen=True)
class Calibration:
    """All that was measured, and what follows."""

    machine: dict[str, Any]
    plan: Plan
    samples: list[Sample]
    over: list[tuple[str, str]]
    seconds: float

    def fits(self) -> list[Fit]:
        """What the steps take: those of the tree as it was built, and those of the kernels for each question."""
        if not self.samples:
            return []
        kinds = {kind: [sample for sample in self.samples if sample.kind == kind] for kind in SEARCHES}
        found = [_fit(SEARCHES[kind], samples, "binary", "binary") for kind, samples in kinds.items() if samples]
        found.append(_fit(LAYOUT, self.samples, " ".join(BINARY), "binary"))
        return found + [_fit(question, self.samples, question, question) for question in map(" ".join, QUESTIONS)]

    def c_trav(self) -> dict[str, float | None]:
        """What a step down costs, in tests of a reference: in the search of the binary tree, and on the layout."""
        return {fit.what: _ratio(fit) for fit in self.fits() if "inner" in fit.ns}

    def mix(self) -> Mix:
        """How much of overlap and how much of area tell most together."""
        return best_mix(self.samples)

    def predictors(self) -> list[Predictor]:
        """How well each figure orders the trees."""
        if not self.samples:
            return []
        layout = self.c_trav()[LAYOUT]
        return predictors(self.samples, None if layout is None else Cost(max(layout, 1e-3)), self.mix())

    def to_json(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "format": "fastlines bench calibrate 1",
            "machine": self.machine,
            "plan": asdict(self.plan),
            "seconds": self.seconds,
            "samples": [sample.to_json() for sample in self.samples],
            "over": [{"scene": scene, "builder": builder, "seconds": self.plan.limit} for scene, builder in self.over],
            "fits": [fit.to_json() for fit in self.fits()],
            "c_trav": self.c_trav(),
            "mix": asdict(self.mix()),
            "predictors": [asdict(predictor) for predictor in self.predictors()],
            "predictor_notes": PREDICTORS,
        }


def _fit(what: str, samples: Sequence[Sample], time: str, steps: str) -> Fit:
    return fit_steps(what, [sample.ns[time] for sample in samples], [sample.steps[steps] for sample in samples])


def _ratio(fit: Fit) -> float | None:
    return fit.ns["inner"] / fit.ns["tests"] if fit.ns["tests"] > 0 else None


def run_calibrate(
    cases: Sequence[Case], plan: Plan, progress: Callable[[str, float], None] = lambda what, share: None
) -> Calibration:
    """Build with all builders, count and time, on one thread.

    Parameters
    ----------
    cases : sequence of Case
    plan : Plan
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    start = time.perf_counter()
    machine = {**describe_machine(), "threads": 1, "simd": simd(), "load": load()}
    samples: list[Sample] = []
    over: list[tuple[str, str]] = []
    with num_threads(1):
        for i, case in enumerate(cases):

            def say(what: str, name: str = case.name, share: float = i / len(cases)) -> None:
                progress(f"{name}: {what}", share)

            grown = build_in_turn(case.lines, plan.builders, 1, plan.limit, say)
            over += [(case.name, name) for name, item in grown.items() if item is None]
            trees = {name: item.tree for name, item in grown.items() if item is not None}
            if trees:
                samples += _samples(case, trees, plan, say)
    return Calibration(machine, plan, samples, over, time.perf_counter() - start)


def _samples(case: Case, trees: dict[str, Tree], plan: Plan, say: Callable[[str], None]) -> list[Sample]:
    """Count and time on one case."""
    for tree in trees.values():
        lay_out(tree)
    turns = ask_in_turn(case, trees, plan.n_rays, plan.seconds, plan.rounds, say)
    turns["binary"] = ask_in_turn(
        case, trees, plan.n_rays, plan.seconds, plan.rounds, say, kernel="binary", questions=[BINARY]
    )[" ".join(BINARY)]
    found = []
    for name, tree in trees.items():
        say(f"counting the steps of {name}")
        ns = {question: turn.seconds[name] / turn.n_rays * 1e9 for question, turn in turns.items()}
        kind, steps, figures = kind_of(tree.settings), _steps(case, tree, plan), _figures(tree, middle_radius(case))
        found.append(Sample(case.name, name, kind, ns, steps, figures))
    return found


def _steps(case: Case, tree: Tree, plan: Plan) -> dict[str, dict[str, float]]:
    """Count what each question takes."""
    radius, rays = middle_radius(case), rays_of(case, plan.n_rays)
    found = {}
    for kind, query in QUESTIONS:
        few = rays[kind].part(COUNTED)
        with counting() as module:
            module.taken()
            hits = count_hits(query, ask_tree(tree, query, few, radius))
            taken = module.taken()
        steps = {step: taken[step] / len(few) for step in STEPS}
        found[f"{kind} {query}"] = {**steps, "hits": hits / len(few)}
    few = rays[BINARY[0]].take(slice(0, None, max(1, len(rays[BINARY[0]]) // WALKED)))
    visits = count_visits(tree, few, radius)
    hits = count_hits(BINARY[1], ask_tree(tree, BINARY[1], few, radius))
    found["binary"] = {"inner": visits.inner, "tests": visits.tests, "hits": hits / len(few)}
    return found


def _figures(tree: Tree, radius: float) -> dict[str, float]:
    """What is known of a tree before it is asked."""
    bare, grown, vain = expect_visits(tree, 0.0), expect_visits(tree, radius), overlap(tree, radius)
    nodes, leaves = expect_wide(tree.layout, radius)
    return {
        "references": tree.n_refs,
        "inner": bare.inner,
        "tests": bare.tests,
        "grown inner": grown.inner,
        "grown tests": grown.tests,
        "vain inner": vain.inner,
        "vain tests": vain.tests,
        "wide nodes": nodes,
        "wide leaves": leaves,
    }
