"""The count of decisions beside float64: how many are outside the band, and how many of them are wrong."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from .scenes import Array
from .values import Values


@dataclass
class Tally:
    """Decisions outside the band, and how many of them are wrong, by shape, scene and instruction set."""

    n: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    wrong: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    n_in_band: int = 0
    #: Batches whose rays the tree refuses.
    n_refused: int = 0
    #: The first wrong decisions, in words.
    examples: list[str] = field(default_factory=list)
    values: Values = field(default_factory=Values)

    def count(self, key: tuple[str, str, str], certain: Array, differs: Array, first: int) -> None:
        """Count certain decisions of rays or points from the first one on, and those that differ."""
        wrong = certain & differs
        self.n[key] += int(certain.sum())
        self.wrong[key] += int(wrong.sum())
        for row, prim in np.argwhere(wrong)[:1]:
            self.examples.append(f"{', '.join(key)}: row {first + row}, primitive {prim}")

    @property
    def n_wrong(self) -> int:
        """The number of wrong decisions and values."""
        return sum(self.wrong.values()) + sum(self.values.wrong.values())

    def add(self, other: Tally) -> None:
        """Add the counts of another tally."""
        self.n.update(other.n)
        self.wrong.update(other.wrong)
        self.n_in_band += other.n_in_band
        self.n_refused += other.n_refused
        self.examples += other.examples[: max(0, 10 - len(self.examples))]
        self.values.add(other.values)
