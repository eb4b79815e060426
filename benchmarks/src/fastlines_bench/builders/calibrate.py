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

from fastlines import Cost, Tree

from ..harness import machine
from ..harness.preset import TimedPreset, sized
from ..harness.rays import QUESTIONS
from ..harness.subjects import Subject
from ..harness.tables import geometric_mean
from ..harness.turns import ask_tree, count_hits
from ..harness.visits import count_visits, expect_visits, expect_wide
from ..package import num_threads
from ..steps import STEPS, count_steps
from .fit import StepFit, fit_steps
from .names import BUILDERS, kind_of
from .overlap import overlap
from .predict import PREDICTORS, Mix, Predictor, best_mix, predictors
from .trees import ask_in_turn, build_in_turn, lay_out

#: What the tree as it was built is asked: a search for all hits visits all that it meets, in whatever order.
BINARY = ("random", "all")

#: How trees of a kind are searched as they were built.
SEARCHES = {"bvh": "binary, by boxes", "kd": "binary, by planes"}

#: The same question to the layout, explained by the steps that the tree as it was built would take.
LAYOUT = "layout, by binary steps"

#: Steps are counted on so many rays at most: by the kernels, and one node at a time.
COUNTED, WALKED = 1 << 14, 1 << 10


@dataclass(frozen=True, kw_only=True)
class CalibratePreset(TimedPreset):
    """How much to measure, on one thread; `builders` and `limit` are those of `BuildersPreset`."""

    n_rays: int = sized(1 << 17, 1 << 15)
    rounds: int = sized(5, 3)
    seconds: float = sized(0.5, 0.1)
    builders: tuple[str, ...] = tuple(name for name, given in BUILDERS.items() if "exhaustive" not in given)
    limit: float = sized(20.0, 5.0)


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
        """Return all figures, ready for JSON."""
        return {**asdict(self), "query_ns": self.query_ns}


@dataclass(frozen=True)
class Calibration:
    """All that was measured, and what follows."""

    machine: dict[str, Any]
    preset: CalibratePreset
    samples: list[Sample]
    over: list[tuple[str, str]]
    seconds: float

    def fits(self) -> list[StepFit]:
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
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench calibrate 1",
            "machine": self.machine,
            "preset": asdict(self.preset),
            "seconds": self.seconds,
            "samples": [sample.to_json() for sample in self.samples],
            "over": [
                {"scene": scene, "builder": builder, "seconds": self.preset.limit} for scene, builder in self.over
            ],
            "fits": [fit.to_json() for fit in self.fits()],
            "c_trav": self.c_trav(),
            "mix": asdict(self.mix()),
            "predictors": [asdict(predictor) for predictor in self.predictors()],
            "predictor_notes": PREDICTORS,
        }


def _fit(what: str, samples: Sequence[Sample], time: str, steps: str) -> StepFit:
    return fit_steps(what, [sample.ns[time] for sample in samples], [sample.steps[steps] for sample in samples])


def _ratio(fit: StepFit) -> float | None:
    return fit.ns["inner"] / fit.ns["tests"] if fit.ns["tests"] > 0 else None


def run_calibrate(
    subjects: Sequence[Subject],
    preset: CalibratePreset,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Calibration:
    """Build with all builders, count and time, on one thread.

    Parameters
    ----------
    subjects : sequence of Subject
    preset : CalibratePreset
    progress : callable
        Called with what is being done, and which share of all is done.
    """
    start = time.perf_counter()
    where = machine.describe(threads=1)
    samples: list[Sample] = []
    over: list[tuple[str, str]] = []
    with num_threads(1):
        for i, subject in enumerate(subjects):

            def say(what: str, name: str = subject.name, share: float = i / len(subjects)) -> None:
                progress(f"{name}: {what}", share)

            grown = build_in_turn(subject.lines, preset.builders, 1, preset.limit, say)
            over += [(subject.name, name) for name, item in grown.items() if item is None]
            trees = {name: item.tree for name, item in grown.items() if item is not None}
            if trees:
                samples += _samples(subject, trees, preset, say)
    return Calibration(where, preset, samples, over, time.perf_counter() - start)


def _samples(
    subject: Subject, trees: dict[str, Tree], preset: CalibratePreset, say: Callable[[str], None]
) -> list[Sample]:
    """Count and time on one subject."""
    for tree in trees.values():
        lay_out(tree)
    turns = ask_in_turn(subject, trees, preset.n_rays, preset.seconds, preset.rounds, say)
    turns["binary"] = ask_in_turn(
        subject, trees, preset.n_rays, preset.seconds, preset.rounds, say, kernel="binary", questions=[BINARY]
    )[" ".join(BINARY)]
    found = []
    for name, tree in trees.items():
        say(f"counting the steps of {name}")
        ns = {question: turn.seconds[name] / turn.n_rays * 1e9 for question, turn in turns.items()}
        kind, steps, figures = (
            kind_of(tree.settings),
            _steps(subject, tree, preset),
            _figures(tree, subject.middle_radius),
        )
        found.append(Sample(subject.name, name, kind, ns, steps, figures))
    return found


def _steps(subject: Subject, tree: Tree, preset: CalibratePreset) -> dict[str, dict[str, float]]:
    """Count what each question takes."""
    radius = subject.middle_radius
    rays = {kind: subject.rays(kind, preset.n_rays) for kind in ("camera", "random")}
    found = {}
    for kind, query in QUESTIONS:
        few = rays[kind].part(COUNTED)
        taken, answer = count_steps(tree, query, few, radius)
        steps = {step: taken[step] for step in STEPS}
        hits = count_hits(query, answer)
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
