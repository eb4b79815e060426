"""Values of answers beside float64: how many there are, and how far they are off."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from .scenes import Array

#: What a value is, such as "cones, entry", and the instruction set that has computed it.
Value: TypeAlias = tuple[str, str]


@dataclass
class Values:
    """Values that were compared, how many are off by more than their bound, and the largest error of each."""

    n: Counter[Value] = field(default_factory=Counter)
    wrong: Counter[Value] = field(default_factory=Counter)
    #: The largest error, as a fraction of its bound.
    largest: dict[Value, float] = field(default_factory=dict)
    #: The first values that are wrong, in words.
    examples: list[str] = field(default_factory=list)

    def check(self, what: str, simd: str, error: Array, bound: Array) -> None:
        """Compare errors with their bounds; what is NaN is wrong."""
        if not error.size:
            return
        bounds = np.broadcast_to(bound, error.shape)
        is_wrong = ~(np.abs(error) <= bounds)
        key = what, simd
        self.n[key] += error.size
        self.wrong[key] += int(is_wrong.sum())
        share = float((np.abs(error) / np.maximum(bounds, 1e-300)).max())
        self.largest[key] = max(self.largest.get(key, 0.0), share)
        if is_wrong.any():
            i = int(np.flatnonzero(is_wrong.reshape(-1))[0])
            off, allowed = float(error.reshape(-1)[i]), float(bounds.reshape(-1)[i])
            self.examples.append(f"{what} on {simd}: off by {off:.3g}, expected at most {allowed:.3g}")

    def add(self, other: Values) -> None:
        """Add the counts of other values."""
        self.n.update(other.n)
        self.wrong.update(other.wrong)
        for key, share in other.largest.items():
            self.largest[key] = max(self.largest.get(key, 0.0), share)
        self.examples += other.examples[: max(0, 10 - len(self.examples))]
