"""A case: geometry, the build of a tree, what is done to the tree, and questions. All of it comes from one seed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from .parts import Part
from .scenes import Array

#: What users do with trees before they query them.
STEPS = (
    *("layout", "pickle", "save", "save with layout", "refit", "without offset"),
    *("forest", "built forest", "mapped forest", "forest of one file"),
)
#: The steps that make a forest of lines of any number of tiles.
FORESTS = ("forest", "built forest", "mapped forest")


@dataclass(frozen=True)
class Question:
    """A query: arrays with a row for each ray, point or box, other arguments, and what answers it."""

    query: str
    rows: dict[str, Array]
    options: dict[str, Any] = field(default_factory=dict)
    kernel: str = "auto"
    simd: str | None = None
    n_threads: int = 1
    #: What the primitives are paired with, for pairs of two trees.
    other: Part | None = None

    def __len__(self) -> int:
        return len(next(iter(self.rows.values()))) if self.rows else 0

    @property
    def noun(self) -> str:
        """What its rows are."""
        return "rays" if "origins" in self.rows else "points" if "points" in self.rows else "boxes"

    def some(self, keep: Array) -> Question:
        """Return the question about these rows alone."""
        return replace(self, rows={name: values[keep] for name, values in self.rows.items()})


@dataclass(frozen=True)
class Case:
    """A tree over some geometry, and questions."""

    parts: tuple[Part, ...]
    build: dict[str, Any]
    steps: tuple[str, ...] = ()
    questions: tuple[Question, ...] = ()
    offset: tuple[float, ...] | None = None
    n_tiles: int = 1
    scene: str = ""
    #: Where rows are given that hold NaN, and are skipped: before which of the others.
    spoiled: tuple[int, ...] = ()
    #: The box of the frame that the build is given, (2, 3) float32; brute force finds it in more primitives.
    frame: Array | None = None

    @property
    def kind(self) -> str:
        """What tables call the geometry."""
        return self.parts[0].label if len(self.parts) == 1 else "several parts"

    @property
    def is_refit(self) -> bool:
        """Whether lines have moved since the build."""
        return "refit" in self.steps

    @property
    def n_prims(self) -> int:
        """The number of primitives."""
        return sum(map(len, self.parts))

    @property
    def whole(self) -> Case:
        """The case over a scene whose box is the frame; what makes it so large comes after the other primitives."""
        if self.frame is None:
            return self
        return replace(self, parts=(*self.parts[:-1], self.parts[-1].with_corners(*self.frame)), frame=None)

    def alone(self, question: Question) -> Case:
        """Return the case with one question."""
        return replace(self, questions=(question,))

    def some(self, keep: Array) -> Case:
        """Return the case over some of the primitives, which are numbered over all parts.

        What questions ignore has the new numbers, or is left out with its primitives.
        """
        first = np.cumsum([0, *map(len, self.parts)])
        kept = [keep[(keep >= a) & (keep < b)] - a for a, b in pairwise(first)]
        parts = tuple(part.some(rows) for part, rows in zip(self.parts, kept, strict=True))
        prims = np.full(self.n_prims + 1, -1)  # the last number is that of −1
        prims[keep] = np.arange(len(keep))
        n_strands = sum(int(part.rows["strands"].max(initial=-1)) + 1 for part in parts if "strands" in part.rows)

        def renumbered(given: dict[str, Any]) -> dict[str, Any]:
            changed = dict(given)
            if "ignore" in given:
                changed["ignore"] = prims[given["ignore"]]
            if "ignore_strands" in given:
                strands = given["ignore_strands"]
                changed["ignore_strands"] = np.where(strands < n_strands, strands, -1)
            return changed

        questions = tuple(
            replace(question, rows=renumbered(question.rows), options=renumbered(question.options))
            for question in self.questions
        )
        spoiled = tuple(min(at, len(keep)) for at in self.spoiled)
        return replace(self, parts=parts, questions=questions, spoiled=spoiled)
