"""What the demonstration found out, as plain data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from ..scenes import RADII
from .measure import Kind, Timing
from .plan import Plan
from .reference import THESIS, Reference

#: The queries of each row, in the order of the thesis's tables.
KINDS: tuple[Kind, ...] = ("first", "all")
QUERIES = [(kind, name) for kind in KINDS for name in RADII]


@dataclass(frozen=True)
class Row:
    """One tree over one scene.

    Attributes
    ----------
    stats : dict
        As `Tree.stats` gives it.
    cost_g : float
        The cost by Theorem 1's other formula.
    timings : dict of (kind, radius's name) to Timing
    """

    scene: str
    method: str
    build_s: float
    stats: dict[str, Any]
    cost_g: float
    timings: dict[tuple[str, str], Timing]

    @property
    def thesis(self) -> Reference | None:
        """What the thesis measured."""
        return THESIS.get(self.scene, {}).get(self.method)


@dataclass(frozen=True)
class SceneResult:
    """One scene, all trees over it, and the names of its pictures' files."""

    name: str
    title: str
    n_segments: int
    n_thesis: int
    rows: list[Row]
    pictures: dict[str, str]
    sheets: dict[str, str]
    n_compared: int


@dataclass(frozen=True)
class Result:
    """All of it."""

    plan: Plan
    machine: dict[str, str | int]
    scenes: list[SceneResult]
    seconds: float

    @property
    def rows(self) -> list[Row]:
        """The rows of all scenes."""
        return [row for scene in self.scenes for row in scene.rows]

    @property
    def largest_difference(self) -> float:
        """How far f and g are apart, as a share of f, where they are furthest."""
        return max((abs(row.stats["cost"] - row.cost_g) / row.stats["cost"] for row in self.rows), default=0.0)

    @property
    def n_compared(self) -> int:
        """How many answers of one tree were compared with those of another."""
        return sum(scene.n_compared for scene in self.scenes)

    @property
    def answers_agree(self) -> bool:
        """Whether answers were compared in every scene; one that differs ends the run before there is a result."""
        return all(scene.n_compared > 0 for scene in self.scenes)

    def to_json(self) -> dict[str, Any]:
        """Everything that the page shows, ready for JSON."""
        return {
            "format": "fastlines demo 1",
            "plan": {**asdict(self.plan), "scenes": dict(self.plan.scenes)},
            "machine": self.machine,
            "radii": RADII,
            "seconds": self.seconds,
            "answers_agree": self.answers_agree,
            "n_answers_compared": self.n_compared,
            "n_trees_valid": len(self.rows),  # one that is not ends the run
            "largest_f_g_difference": self.largest_difference,
            "scenes": [
                {
                    "name": scene.name,
                    "title": scene.title,
                    "n_segments": scene.n_segments,
                    "pictures": scene.pictures,
                    "level_sheets": scene.sheets,
                    "trees": [_row_to_json(row) for row in scene.rows],
                }
                for scene in self.scenes
            ],
        }


def _row_to_json(row: Row) -> dict[str, Any]:
    queries: dict[str, dict[str, Any]] = {"first": {}, "all": {}}
    for (kind, radius), timing in row.timings.items():
        queries[kind][radius] = {**asdict(timing), "ms": timing.ms, "mrays_per_s": timing.mrays}
    thesis = None if row.thesis is None else asdict(row.thesis)
    return {**row.stats, "build_s": row.build_s, "cost_g": row.cost_g, "queries": queries, "thesis": thesis}
