"""Which figures of a tree, known before any query, order trees as their query times do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fastlines import Cost

from ..harness.rays import QUESTIONS
from ..harness.visits import Visits
from .names import THESIS_COST
from .ranks import kendall, spearman

if TYPE_CHECKING:
    from .calibrate import Sample

#: What each figure is.
PREDICTORS = {
    "cost": "the thesis's cost, c_trav 2",
    "cost, grown": "the same, of boxes grown by the radius of the queries",
    "cost, calibrated": "the same, with the c_trav that fits the layout here",
    "overlap": "end-point overlap of the grown boxes, c_trav 2",
    "cost + overlap": "(1 − α)·cost, grown + α·overlap, with the best α",
    "wide": "the layout's own cost, of grown boxes: 1.2 a node, 1 a leaf",
    "references": "how many references the tree has: no model at all",
}

#: What the layout is made for (layout/collapse.hpp).
WIDE_NODE_COST, WIDE_LEAF_COST = 1.2, 1.0

#: The share of overlap is tried in so many steps.
SHARES = 20


@dataclass(frozen=True)
class Correlation:
    """How alike two orders are, by Spearman's ρ and by Kendall's τ_b; None where one side is the same throughout."""

    spearman: float | None
    kendall: float | None


@dataclass(frozen=True)
class Mix:
    """The share α of overlap beside area, and what ρ it has, on average over the scenes."""

    alpha: float
    spearman: float | None


@dataclass(frozen=True)
class Predictor:
    """A figure of trees, and how it orders them.

    Attributes
    ----------
    scenes : dict of str to Correlation
        With the mean query time, among the builders of each scene.
    overall : Correlation
        Among all trees of all scenes.
    questions : dict of str to Correlation
        Likewise, with the time of each question alone.
    regret : float
        How much longer queries take on the tree of the lowest figure than on the fastest: the mean over the scenes, in
        parts of the latter.
    """

    name: str
    scenes: dict[str, Correlation]
    overall: Correlation
    questions: dict[str, Correlation]
    regret: float


def predictors(samples: Sequence[Sample], calibrated: Cost | None, mix: Mix) -> list[Predictor]:
    """Tell how well each figure of `PREDICTORS` does.

    Parameters
    ----------
    samples : sequence of Sample
    calibrated : Cost or None
        The model that fits the layout; without one, that figure is left out.
    mix : Mix
        The share of overlap.
    """
    thesis = THESIS_COST["bvh"]
    figures: dict[str, Callable[[Sample], float]] = {
        "cost": lambda sample: _cost(sample, "", thesis),
        "cost, grown": lambda sample: _cost(sample, "grown ", thesis),
        "overlap": lambda sample: _cost(sample, "vain ", thesis),
        "cost + overlap": lambda sample: mixed(sample, mix.alpha),
        "wide": lambda sample: (
            WIDE_NODE_COST * sample.figures["wide nodes"] + WIDE_LEAF_COST * sample.figures["wide leaves"]
        ),
        "references": lambda sample: sample.figures["references"],
    }
    if calibrated is not None:
        figures["cost, calibrated"] = lambda sample: _cost(sample, "grown ", calibrated)
    return [_predictor(name, figures[name], samples) for name in PREDICTORS if name in figures]


def mixed(sample: Sample, alpha: float) -> float:
    """Area and overlap in one figure, as the paper has it."""
    thesis = THESIS_COST["bvh"]
    return (1 - alpha) * _cost(sample, "grown ", thesis) + alpha * _cost(sample, "vain ", thesis)


def best_mix(samples: Sequence[Sample]) -> Mix:
    """Find the share of overlap with the highest ρ, on average over the scenes; of equal ones, the smallest."""
    best = Mix(0.0, None)
    for i in range(SHARES + 1):
        alpha = i / SHARES
        found = [
            spearman([mixed(sample, alpha) for sample in some], [sample.query_ns for sample in some])
            for some in by_scene(samples).values()
        ]
        known = [rho for rho in found if rho is not None]
        mean = sum(known) / len(known) if known else None
        if mean is not None and (best.spearman is None or mean > best.spearman + 1e-12):
            best = Mix(alpha, mean)
    return best


def by_scene(samples: Sequence[Sample]) -> dict[str, list[Sample]]:
    """The samples of each scene."""
    found: dict[str, list[Sample]] = {}
    for sample in samples:
        found.setdefault(sample.scene, []).append(sample)
    return found


def _cost(sample: Sample, which: str, model: Cost) -> float:
    return Visits(sample.figures[f"{which}inner"], sample.figures[f"{which}tests"]).cost(model)


def _predictor(name: str, figure: Callable[[Sample], float], samples: Sequence[Sample]) -> Predictor:
    def correlate(some: Sequence[Sample], time: Callable[[Sample], float]) -> Correlation:
        sides = [figure(sample) for sample in some], [time(sample) for sample in some]
        return Correlation(spearman(*sides), kendall(*sides))

    def mean_time(sample: Sample) -> float:
        return sample.query_ns

    def time_of(question: str) -> Callable[[Sample], float]:
        return lambda sample: sample.ns[question]

    scenes = by_scene(samples)
    chosen = [min(some, key=figure).query_ns / min(map(mean_time, some)) - 1 for some in scenes.values()]
    return Predictor(
        name,
        {scene: correlate(some, mean_time) for scene, some in scenes.items()},
        correlate(samples, mean_time),
        {question: correlate(samples, time_of(question)) for question in map(" ".join, QUESTIONS)},
        sum(chosen) / len(chosen),
    )
