"""Rank correlations of query times with figures of trees that are known before any query."""

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

#: A description of each figure.
PREDICTORS = {
    "cost": "the thesis's cost, c_trav 2",
    "cost, grown": "the same, of boxes enlarged by the radius of the queries",
    "cost, calibrated": "the same, with the c_trav fitted to the layout",
    "overlap": "end-point overlap of the enlarged boxes, c_trav 2",
    "cost + overlap": "(1 − α)·cost, grown + α·overlap, with the best α",
    "wide": "the layout's own cost, of enlarged boxes: 1.2 a node, 1 a leaf",
    "references": "the number of references, without a model",
}

#: The costs that the layout minimises (layout/collapse.hpp).
WIDE_NODE_COST, WIDE_LEAF_COST = 1.2, 1.0

#: The number of steps in which the share of overlap is varied.
SHARES = 20


@dataclass(frozen=True)
class Correlation:
    """The rank correlations of two orders, Spearman's ρ and Kendall's τ_b; None if one side is constant."""

    spearman: float | None
    kendall: float | None


@dataclass(frozen=True)
class Mix:
    """The share α of overlap in a mix with area, and the mean of its ρ over the scenes."""

    alpha: float
    spearman: float | None


@dataclass(frozen=True)
class Predictor:
    """The correlations of a figure of trees with query times.

    Attributes
    ----------
    scenes : dict of str to Correlation
        The correlation with the mean query time, among the builders of each scene.
    overall : Correlation
        The same, among all trees of all scenes.
    questions : dict of str to Correlation
        The correlation with the time of each question, among all trees of all scenes.
    regret : float
        The relative slowdown of the tree with the lowest figure against the fastest tree: the mean over the scenes.
    """

    name: str
    scenes: dict[str, Correlation]
    overall: Correlation
    questions: dict[str, Correlation]
    regret: float


def predictors(samples: Sequence[Sample], calibrated: Cost | None, mix: Mix) -> list[Predictor]:
    """Return the correlations of each figure of `PREDICTORS`.

    Parameters
    ----------
    samples : sequence of Sample
    calibrated : Cost or None
        The model that is fitted to the layout; if None, its figure is left out.
    mix : Mix
        The share of overlap in "cost + overlap".
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
    """Return the mix of area and overlap, as in the paper."""
    thesis = THESIS_COST["bvh"]
    return (1 - alpha) * _cost(sample, "grown ", thesis) + alpha * _cost(sample, "vain ", thesis)


def best_mix(samples: Sequence[Sample]) -> Mix:
    """Return the share of overlap with the highest mean ρ over the scenes; the smallest of equal shares."""
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
    """Return the samples of each scene."""
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
