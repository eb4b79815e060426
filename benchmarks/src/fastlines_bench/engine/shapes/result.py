"""The result of the benchmark of shapes, as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from ...harness.findings import Check
from ...harness.tables import geometric_mean
from ..result import EngineCell
from .names import MOST_OF_LINES, SHAPES, Question


@dataclass(frozen=True)
class ShapeCell:
    """A cell of the engine, and the shape that it is about."""

    shape: str
    cell: EngineCell

    @property
    def question(self) -> Question:
        """The kind of rays and the query."""
        return self.cell.kind, self.cell.query

    def times_of_lines(self, side: str = "") -> float | None:
        """Return our time as a multiple of that of lines of the same radius: of cones, or of another side."""
        others = self.cell.others
        if "lines" not in others:
            return None
        return others["lines"] / (others[side] if side else self.cell.mrays)

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        more = {"cones_to_lines": self.times_of_lines(), "capsules_to_lines": self.times_of_lines("capsules")}
        more = more if self.shape == "cones" else {}
        return {"shape": self.shape, **self.cell.to_json(), **more}


@dataclass(frozen=True)
class ShapeBuilt:
    """Our tree over shapes: the seconds of the build and the layout, the bytes of the layout, and what it is over."""

    shape: str
    scene: str
    radius: float
    n_shapes: int
    n_prims: int
    build_s: float
    layout_s: float
    bytes: int
    note: str


@dataclass(frozen=True)
class Missing:
    """Shapes that could not be measured, and why."""

    shape: str
    scene: str
    radius: float
    why: str


@dataclass(frozen=True)
class Result:
    """All cells, the builds, and what is missing."""

    machine: dict[str, Any]
    preset: dict[str, Any]
    built: list[ShapeBuilt]
    missing: list[Missing]
    cells: list[ShapeCell]
    seconds: float

    def of(self, shape: str, question: Question | None = None) -> list[ShapeCell]:
        """Return the cells of a shape, and of one kind of rays and query."""
        return [cell for cell in self.cells if cell.shape == shape and question in (None, cell.question)]

    def mean(self, shape: str, question: Question) -> float | None:
        """Return the geometric mean of the ratios to Embree: Embree's time divided by ours."""
        return geometric_mean([cell.cell.ratio for cell in self.of(shape, question)])

    def mean_of_lines(self, question: Question | None = None, side: str = "") -> float | None:
        """Return the geometric mean of our times as multiples of those of lines."""
        ratios = [cell.times_of_lines(side) for cell in self.of("cones", question)]
        return geometric_mean([ratio for ratio in ratios if ratio is not None])

    def checks(self) -> list[Check]:
        """Return the bounds that are wanted, as checks of the means; what was not measured is not a figure."""
        found = []
        for shape in self.preset["shapes"]:
            for (kind, query), least in SHAPES[shape].floors.items():
                ratio = self.mean(shape, (kind, query))
                found.append(Check(f"{shape}, {kind} {query}: ratio to Embree", ratio, least=least))
                if shape == "cones":
                    for name in ("cones", "capsules"):
                        times = self.mean_of_lines((kind, query), "" if name == "cones" else name)
                        what = f"{shape}, {kind} {query}: time of {name} as a multiple of that of lines"
                        found.append(Check(what, times, MOST_OF_LINES))
        return found

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench shapes 1",
            "machine": self.machine,
            "preset": self.preset,
            "seconds": self.seconds,
            "built": [asdict(built) for built in self.built],
            "missing": [asdict(missing) for missing in self.missing],
            "geometric_means": [
                {
                    "shape": shape,
                    "kind": question[0],
                    "query": question[1],
                    "ratio": self.mean(shape, question),
                    "floor": SHAPES[shape].floors.get(question),
                    "cones_to_lines": self.mean_of_lines(question) if shape == "cones" else None,
                    "capsules_to_lines": self.mean_of_lines(question, "capsules") if shape == "cones" else None,
                }
                for shape, question in dict.fromkeys((cell.shape, cell.question) for cell in self.cells)
            ],
            "checks": [check.to_json() for check in self.checks()],
            "cells": [cell.to_json() for cell in self.cells],
        }
