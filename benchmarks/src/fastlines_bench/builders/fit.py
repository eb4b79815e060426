"""What a step takes: times explained as sums of steps, none of which takes less than nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np


@dataclass(frozen=True)
class StepFit:
    """Times as sums of steps.

    Attributes
    ----------
    what : str
        What was timed.
    n : int
        How many times were fitted.
    ns : dict of str to float
        Nanoseconds a step; 0 where a step explains nothing that the others do not.
    error, worst : float
        Relative errors of the sums: the median and the largest.
    """

    what: str
    n: int
    ns: dict[str, float]
    error: float
    worst: float

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"what": self.what, "n": self.n, "ns": self.ns, "error": self.error, "worst": self.worst}


def fit_steps(what: str, times: Sequence[float], steps: Sequence[Mapping[str, float]]) -> StepFit:
    """Find the nanoseconds of each step: least squares of the relative errors, with none below zero.

    Of all choices of steps that come out positive the best is taken, which is the exact solution.

    Parameters
    ----------
    what : str
    times : sequence of float
        Nanoseconds, above zero.
    steps : sequence of dict of str to float
        How many of each were taken; all have the same names.

    Examples
    --------
    >>> steps = [{"nodes": 1, "tests": 5}, {"nodes": 4, "tests": 2}, {"nodes": 3, "tests": 3}]
    >>> fit = fit_steps("a search", [13, 28, 23], steps)
    >>> {name: round(ns, 6) for name, ns in fit.ns.items()}
    {'nodes': 6.333333, 'tests': 1.333333}
    """
    names = list(steps[0])
    rows = np.array([[row[name] for name in names] for row in steps], np.float64) / np.asarray(times)[:, None]
    used = [i for i in range(len(names)) if rows[:, i].any()]
    best, least = np.zeros(len(names)), float(len(rows))
    for size in range(1, len(used) + 1):
        for chosen in combinations(used, size):
            some = rows[:, chosen]
            found, *_ = np.linalg.lstsq(some, np.ones(len(rows)), rcond=None)
            rest = float(((some @ found - 1) ** 2).sum())
            if (found >= 0).all() and rest < least:
                best, least = np.zeros(len(names)), rest
                best[list(chosen)] = found
    errors = np.abs(rows @ best - 1)
    return StepFit(
        what,
        len(rows),
        dict(zip(names, best.tolist(), strict=True)),
        float(np.median(errors)),
        float(errors.max()),
    )
