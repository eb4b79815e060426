"""What ought to hold of figures: checks, which are inequalities, and findings, which are some of them together."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

#: A figure may pass its bound by this share of it: rounding in float64.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Check:
    """A figure and the bounds that it must keep; None = not measured.

    Attributes
    ----------
    what : str
    figure : float or None
    most : float or None
        Its upper bound; None where what it is compared with was not measured.
    least : float
    scene : str
        Where it was measured.
    """

    what: str
    figure: float | None
    most: float | None = float("inf")
    least: float = 0.0
    scene: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the figure keeps its bounds; None if something was not measured."""
        if self.figure is None or self.most is None:
            return None
        return self.least * (1 - ROUNDING) <= self.figure <= self.most * (1 + ROUNDING)

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {**asdict(self), "holds": self.holds}


@dataclass(frozen=True)
class Finding:
    """A sentence that holds if all of its checks do."""

    text: str
    checks: tuple[Check, ...]

    @property
    def holds(self) -> bool | None:
        """Whether it does; None if a part was not measured and no other speaks against it."""
        verdicts = [check.holds for check in self.checks]
        return False if False in verdicts else None if None in verdicts else True
