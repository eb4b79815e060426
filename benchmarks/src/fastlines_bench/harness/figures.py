"""What a part of the benchmark has found: a table, notes, and what was wanted."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from .arrays import Float64Array
from .findings import Check


@dataclass(frozen=True)
class Figures:
    """A table of figures, one row a measurement.

    Attributes
    ----------
    name, title : str
        The name of the part, and the heading of its table.
    heads : tuple of str
        The names of the columns.
    rows : list of tuple
        Texts and numbers.
    notes : list of str
        Sentences below the table.
    checks : list of Check
        What was wanted.
    points : list of dict
        What a plot draws.
    pictures : dict of str to (height, width, 3) array
        The pictures that it draws.
    """

    name: str
    title: str
    heads: tuple[str, ...]
    rows: list[tuple[Any, ...]]
    notes: list[str] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    points: list[dict[str, Any]] = field(default_factory=list)
    pictures: dict[str, Float64Array] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON, without the pictures."""
        figures = {name: value for name, value in asdict(self).items() if name != "pictures"}
        return {**figures, "checks": [check.to_json() for check in self.checks]}
