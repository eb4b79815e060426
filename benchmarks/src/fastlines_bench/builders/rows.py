"""What is measured of a builder on a scene: its tree and its times, that it took too long, or Embree's builds."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from ..harness.tables import geometric_mean


@dataclass(frozen=True)
class BuilderRow:
    """A builder's tree over a scene.

    Attributes
    ----------
    kind : {"bvh", "kd"}
    cost : float
        The cost with the builder's own c_trav.
    thesis_cost : float
        The cost with `THESIS_COST`, which is the same model for all trees of a kind.
    builds : tuple of float
        Seconds of each build.
    layout_s : float
        Seconds of the layout.
    bytes : int
        The size of the layout and the segments.
    ns : dict of str to float
        Nanoseconds per ray, by question.
    limits_hit : dict of str to int
        A copy of `Tree.limits_hit`.
    """

    scene: str
    n_segments: int
    builder: str
    kind: str
    n_refs: int
    n_nodes: int
    c_trav: float
    cost: float
    thesis_cost: float
    builds: tuple[float, ...]
    layout_s: float
    bytes: int
    ns: dict[str, float]
    limits_hit: dict[str, int]

    @property
    def build_s(self) -> float:
        """The median seconds of a build."""
        return median(self.builds)

    @property
    def query_ns(self) -> float:
        """Nanoseconds per ray: the geometric mean over all questions."""
        return geometric_mean(list(self.ns.values())) or 0.0

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {**asdict(self), "build_s": self.build_s, "query_ns": self.query_ns}


@dataclass(frozen=True)
class Over:
    """A builder whose build was aborted at the limit of `seconds`."""

    scene: str
    builder: str
    seconds: float


@dataclass(frozen=True)
class Peer:
    """The builds of Embree's scene in the configuration whose queries are fastest, over all questions."""

    scene: str
    config: str
    builds: tuple[float, ...]
    bytes: int

    @property
    def build_s(self) -> float:
        """The median seconds of a build."""
        return median(self.builds)
