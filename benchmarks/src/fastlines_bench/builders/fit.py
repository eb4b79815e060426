"""Fit times as sums of steps with nonnegative times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np


@dataclass(frozen=True)
class StepFit:
    """A fit of times as sums of steps.

    Attributes
    ----------
    what : str
        What was timed.
    n : int
        The number of fitted times.
    ns : dict of str to float
        Nanoseconds per step; 0 for a step that does not improve the fit.
    error, worst : float
        The median and the maximum of the relative errors.
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
    """Fit the nanoseconds of each step by nonnegative least squares of the relative errors.

    All subsets of steps are tried; the best one whose times are all nonnegative is the exact solution.

    Parameters
    ----------
    what : str
    times : sequence of float
        Nanoseconds; all are positive.
    steps : sequence of dict of str to float
        The number of steps of each kind; all have the same names.

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
