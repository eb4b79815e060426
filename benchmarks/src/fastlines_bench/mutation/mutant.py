"""A mutant: a small fault in the code, and what became of it."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

Found = TypeVar("Found")

#: What may become of a mutant. One that is not reached is run by no test; an equal one gives the same answers.
STATUSES = ("killed", "survived", "not reached", "equal")


@dataclass
class Mutant:
    """One expression or statement, what replaces it, and whether a test notices.

    Attributes
    ----------
    number : int
        The value of the switch; from 1.
    file, line, place
        Where it is; the place is the function, or the line of code without its indentation.
    original, replacement : str
        What is there, and what is there instead.
    status : str
        One of `STATUSES`, or "" if it was not tried.
    by : str
        The test that noticed it and how, or the reason why it is equal.
    nth : int
        Which one it is of the mutants of its file with the same place, original and replacement; from 0.
    """

    number: int
    file: str
    line: int
    place: str
    original: str
    replacement: str
    status: str = ""
    by: str = ""
    nth: int = 0

    @property
    def key(self) -> tuple[str, str, str, str, int]:
        """What stays the same if other lines are inserted before it."""
        return self.file, self.place, self.original, self.replacement, self.nth

    @property
    def is_undetected(self) -> bool:
        """Whether no test noticed it, and it is not known to be equal."""
        return self.status in ("survived", "not reached")


def tell_apart(mutants: Iterable[Mutant]) -> None:
    """Number the mutants of each file whose texts are the same."""
    seen: Counter[tuple[str | int, ...]] = Counter()
    for mutant in mutants:
        key = mutant.key[:-1]
        mutant.nth = seen[key]
        seen[key] += 1


def score(mutants: Iterable[Mutant]) -> float:
    """Return the share of the mutants that were killed, of all that were tried and are not equal."""
    tried = [mutant for mutant in mutants if mutant.status not in ("", "equal")]
    return sum(mutant.status == "killed" for mutant in tried) / max(len(tried), 1)


def draw(found: Sequence[Found], sample: int | None, seed: int) -> list[Found]:
    """Return a sample of the mutants, in their order; all of them without a size."""
    if sample is None or sample >= len(found):
        return list(found)
    return [found[i] for i in sorted(random.Random(seed).sample(range(len(found)), sample))]
