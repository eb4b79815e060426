"""The time of a step on this machine, and which figures of trees predict their query times.

First, the nanoseconds of each step are fitted: of the traversal of the binary tree, which the cost model describes
(c_trav for an inner node, c_prim for a test), and of the kernels on the wide layout. Second, figures that are known
before any query are correlated with the query times of the trees of all builders.
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
from ..harness.turns import count_hits, query_tree
from ..harness.visits import count_visits, expect_visits, expect_wide
from ..package import num_threads
from ..steps import STEPS, count_steps
from .fit import StepFit, fit_steps
from .names import BUILDERS, kind_of
from .overlap import overlap
from .predict import PREDICTORS, Mix, Predictor, best_mix, predictors
from .trees import alternate_builds, alternate_queries, time_layout

#: The question for the binary tree. A traversal for all hits visits every node that the ray hits, in any order.
BINARY = ("random", "all")

#: The traversals of binary trees, by kind.
SEARCHES = {"bvh": "binary, by boxes", "kd": "binary, by planes"}

#: The same question to the layout, fitted by the steps of the binary tree.
LAYOUT = "layout, by binary steps"

#: The maximum number of rays on which steps are counted: by the kernels, and in the binary tree.
COUNTED, WALKED = 1 << 14, 1 << 10


@dataclass(frozen=True, kw_only=True)
class CalibratePreset(TimedPreset):
    """How much to measure, on one thread; `builders` and `limit` are as in `BuildersPreset`."""

    n_rays: int = sized(1 << 17, 1 << 15)
    rounds: int = sized(5, 3)
    seconds: float = sized(0.5, 0.1)
    builders: tuple[str, ...] = tuple(name for name, given in BUILDERS.items() if "exhaustive" not in given)
    limit: float = sized(20.0, 5.0)


@dataclass(frozen=True)
class Sample:
    """The counts and times of a tree.

    Attributes
    ----------
    kind : str
        "bvh" or "kd".
    ns : dict of str to float
        Nanoseconds per ray, by question; "binary" is the traversal of the binary tree.
    steps : dict of str to dict
        The kernels' steps per ray, by question; "binary" has inner nodes, tests and hits.
    figures : dict of str to float
        The number of references, expected steps and overlap, of which `predict.predictors` makes predictors.
    """

    scene: str
    builder: str
    kind: str
    ns: dict[str, float]
    steps: dict[str, dict[str, float]]
    figures: dict[str, float]

    @property
    def query_ns(self) -> float:
        """Nanoseconds per ray of the kernels: the geometric mean over all questions."""
        return geometric_mean([self.ns[" ".join(question)] for question in QUESTIONS]) or 0.0

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {**asdict(self), "query_ns": self.query_ns}


@dataclass(frozen=True)
class Calibration:
    """All samples, and what follows from them."""

    machine: dict[str, Any]
    preset: CalibratePreset
    samples: list[Sample]
    over: list[tuple[str, str]]
    seconds: float

    def fits(self) -> list[StepFit]:
        """Return the fits of the traversal of binary trees, and of the kernels for each question."""
        if not self.samples:
            return []
        kinds = {kind: [sample for sample in self.samples if sample.kind == kind] for kind in SEARCHES}
        found = [_fit(SEARCHES[kind], samples, "binary", "binary") for kind, samples in kinds.items() if samples]
        found.append(_fit(LAYOUT, self.samples, " ".join(BINARY), "binary"))
        return found + [_fit(question, self.samples, question, question) for question in map(" ".join, QUESTIONS)]

    def c_trav(self) -> dict[str, float | None]:
        """Return the time of an inner node by that of a test, for binary trees and for the layout; None if unknown."""
        return {fit.what: _ratio(fit) for fit in self.fits() if "inner" in fit.ns}

    def mix(self) -> Mix:
        """Return the mix of area and overlap that correlates best with query times."""
        return best_mix(self.samples)

    def predictors(self) -> list[Predictor]:
        """Return the rank correlations of all figures with query times."""
        if not self.samples:
            return []
        layout = self.c_trav()[LAYOUT]
        return predictors(self.samples, None if layout is None else Cost(max(layout, 1e-3)), self.mix())

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench calibrate 2",
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
    """Build with all builders, count steps and time queries, on one thread.

    Parameters
    ----------
    subjects : sequence of Subject
    preset : CalibratePreset
    progress : callable
        Called with the current work and the share of all work that is done.
    """
    start = time.perf_counter()
    where = machine.describe(threads=1)
    samples: list[Sample] = []
    over: list[tuple[str, str]] = []
    with num_threads(1):
        for i, subject in enumerate(subjects):

            def say(what: str, name: str = subject.name, share: float = i / len(subjects)) -> None:
                progress(f"{name}: {what}", share)

            built = alternate_builds(subject.lines, preset.builders, 1, preset.limit, say)
            over += [(subject.name, name) for name, item in built.items() if item is None]
            trees = {name: item.tree for name, item in built.items() if item is not None}
            if trees:
                samples += _samples(subject, trees, preset, say)
    return Calibration(where, preset, samples, over, time.perf_counter() - start)


def _samples(
    subject: Subject, trees: dict[str, Tree], preset: CalibratePreset, say: Callable[[str], None]
) -> list[Sample]:
    """Return the samples of one subject."""
    for tree in trees.values():
        time_layout(tree)
    timings = alternate_queries(subject, trees, preset.n_rays, preset.seconds, preset.rounds, say)
    timings["binary"] = alternate_queries(
        subject, trees, preset.n_rays, preset.seconds, preset.rounds, say, kernel="binary", questions=[BINARY]
    )[" ".join(BINARY)]
    found = []
    for name, tree in trees.items():
        say(f"counting the steps of {name}")
        ns = {question: timing.seconds[name] / timing.n_rays * 1e9 for question, timing in timings.items()}
        kind, steps, figures = (
            kind_of(tree.settings),
            _steps(subject, tree, preset),
            _figures(tree, subject.middle_radius),
        )
        found.append(Sample(subject.name, name, kind, ns, steps, figures))
    return found


def _steps(subject: Subject, tree: Tree, preset: CalibratePreset) -> dict[str, dict[str, float]]:
    """Return the steps of each question."""
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
    hits = count_hits(BINARY[1], query_tree(tree, BINARY[1], few, radius))
    found["binary"] = {"inner": visits.inner, "tests": visits.tests, "hits": hits / len(few)}
    return found


def _figures(tree: Tree, radius: float) -> dict[str, float]:
    """Return the figures of a tree that are known before any query."""
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
