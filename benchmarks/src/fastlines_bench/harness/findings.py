"""Checks, which are inequalities that figures should satisfy, and findings, which are groups of checks."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

#: The relative tolerance of a bound, for rounding in float64.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Check:
    """A figure and its bounds; None = not measured.

    Attributes
    ----------
    what : str
    figure : float or None
    most : float or None
        The upper bound; None if the figure that it depends on was not measured.
    least : float
        The lower bound.
    scene : str
        The scene of the figure.
    """

    what: str
    figure: float | None
    most: float | None = float("inf")
    least: float = 0.0
    scene: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the figure is within its bounds; None if it or the bound was not measured."""
        if self.figure is None or self.most is None:
            return None
        return self.least * (1 - ROUNDING) <= self.figure <= self.most * (1 + ROUNDING)

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON, which has no infinity: then `most` is None."""
        return {**asdict(self), "most": None if self.most == float("inf") else self.most, "holds": self.holds}


@dataclass(frozen=True)
class Finding:
    """A sentence that holds if all of its checks do."""

    text: str
    checks: tuple[Check, ...]

    @property
    def holds(self) -> bool | None:
        """Whether all checks hold; None if one was not measured and no other fails."""
        verdicts = [check.holds for check in self.checks]
        return False if False in verdicts else None if None in verdicts else True
