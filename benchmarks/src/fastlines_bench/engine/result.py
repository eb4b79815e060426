"""The result of the benchmark, as plain data."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import asdict, dataclass, field
from typing import Any

from ..harness.compare import Difference
from ..harness.tables import geometric_mean
from ..peers.embree import Config


@dataclass(frozen=True)
class Side:
    """The result of a configuration of the peer in a cell.

    Attributes
    ----------
    mrays : float
        Millions of rays per second in the fastest round.
    n_rays, n_rounds : int
        The numbers of rays and rounds; 0 rounds if it was much slower than the fastest in the trial, and not timed.
    """

    config: Config
    mrays: float
    n_rays: int
    n_rounds: int
    build_s: float
    bytes: int
    difference: Difference

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        difference = {**asdict(self.difference), "share": self.difference.share}
        figures = {key: getattr(self, key) for key in ("mrays", "n_rays", "n_rounds", "build_s", "bytes")}
        return {**self.config.to_json(), **figures, "difference": difference}


@dataclass(frozen=True)
class EngineCell:
    """The results for a kind of rays, a query, a scene and a radius: ours, and those of the peer's configurations."""

    scene: str
    radius: float
    kind: str
    query: str
    n_rays: int
    n_hits: int
    mrays: float
    sides: list[Side]
    #: Millions of rays per second of other queries of ours, which took turns with it.
    others: dict[str, float] = field(default_factory=dict)

    @property
    def best(self) -> Side | None:
        """The peer's fastest configuration, whatever its definition of a hit; None without a peer."""
        return max((side for side in self.sides if side.n_rounds), key=lambda side: side.mrays, default=None)

    @property
    def exact(self) -> Side | None:
        """The fastest configuration with our definition of a hit; None without a peer."""
        user = [side for side in self.sides if side.n_rounds and side.config.build.geometry == "user"]
        return max(user, key=lambda side: side.mrays, default=None)

    @property
    def ratio(self) -> float:
        """Our rays per second divided by those of `best`; NaN without a peer."""
        return self.mrays / self.best.mrays if self.best else math.nan

    @property
    def exact_ratio(self) -> float:
        """Our rays per second divided by those of `exact`; NaN without a peer."""
        return self.mrays / self.exact.mrays if self.exact else math.nan

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        figures = {key: getattr(self, key) for key in ("scene", "radius", "kind", "query", "n_rays", "n_hits", "mrays")}
        best, exact = self.best, self.exact
        return {
            **figures,
            "ratio": self.ratio if best else None,
            "best": str(best.config) if best else None,
            "exact_ratio": self.exact_ratio if exact else None,
            "best_exact": str(exact.config) if exact else None,
            **({"others": self.others} if self.others else {}),
            "peers": [side.to_json() for side in self.sides],
        }


@dataclass(frozen=True)
class Built:
    """Our tree over a scene: the seconds of the build and the layout, and the bytes of the layout with its segments."""

    scene: str
    n_segments: int
    method: str
    build_s: float
    layout_s: float
    bytes: int


@dataclass(frozen=True)
class Result:
    """All cells, and the builds."""

    machine: dict[str, Any]
    preset: dict[str, Any]
    built: list[Built]
    cells: list[EngineCell]
    seconds: float

    def groups(self) -> dict[tuple[str, str], list[EngineCell]]:
        """Return the cells of each kind of rays and query."""
        found: dict[tuple[str, str], list[EngineCell]] = {}
        for cell in self.cells:
            found.setdefault((cell.kind, cell.query), []).append(cell)
        return found

    def usual(self, scene: str, radius: float) -> Side | None:
        """Return a result of the peer's build that is best in most cells of a scene and radius; None without a peer."""
        best = [cell.best for cell in self.cells if (cell.scene, cell.radius) == (scene, radius)]
        sides = [side for side in best if side is not None]
        wins = Counter(side.config.build for side in sides)
        return max(sides, key=lambda side: wins[side.config.build], default=None)

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {
            "format": "fastlines-bench engine 1",
            "machine": self.machine,
            "preset": self.preset,
            "seconds": self.seconds,
            "built": [asdict(built) for built in self.built],
            "geometric_means": [
                {
                    "kind": kind,
                    "query": query,
                    "ratio": geometric_mean([cell.ratio for cell in cells]),
                    "exact_ratio": geometric_mean([cell.exact_ratio for cell in cells]),
                }
                for (kind, query), cells in self.groups().items()
            ],
            "cells": [cell.to_json() for cell in self.cells],
        }
