"""What ought to hold of the builder `best`, beside what was measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from ..methods import THESIS_METHODS

if TYPE_CHECKING:
    from .pareto import Peer, Row

#: The tree for queries, and those of least cost, by kind.
QUERIES = "best"
LEAST = {"bvh": "best-bvh", "kd": "best-kd"}

#: What the trees of least cost may cost on the thesis's scenes: the scene, its segments, the builder, the bound.
COSTS = (
    ("spaghetti", 2000, "best-bvh", 269.0),
    ("spaghetti", 2000, "best-bvh@1", 262.0),
    ("spaghetti", 2000, "best-kd", 137.6),
    ("spaghetti-2", 8000, "best-bvh", 540.0),
    ("spaghetti-2", 8000, "best-kd", 276.0),
)

#: Which share of another builder's time these may take on spaghetti.
SHARES = (
    ("best-bvh", "bvh-d2", 1 / 3),
    ("best-kd", "kd-d2", 1 / 10),
    ("best-kd", "kd-d2-exhaustive", 1 / 10),
)

#: The query time of `best`, in parts of the fastest of all.
NEAR = 1.02

#: From so many segments on, two threads take at most half of Embree's time.
LARGE = 1_000_000


@dataclass(frozen=True)
class Claim:
    """Something measured, and what it may be at most; None = not measured."""

    scene: str
    says: str
    value: float | None
    bound: float | None

    @property
    def holds(self) -> bool | None:
        """Whether it does, but for rounding in float64; None if something was not measured."""
        if self.value is None or self.bound is None:
            return None
        return self.value <= self.bound * (1 + 1e-9)

    def to_json(self) -> dict[str, Any]:
        """Everything."""
        return {**asdict(self), "holds": self.holds}


def claims(rows: Sequence[Row], peers: Sequence[Peer], n_threads: int) -> list[Claim]:
    """List what ought to hold on each scene.

    What a claim compares with may itself not have been built within the limit of time; then the claim names what was.
    """
    found: list[Claim] = []
    for scene in dict.fromkeys(row.scene for row in rows):
        by_name = {row.builder: row for row in rows if row.scene == scene}
        found += _never_costlier(scene, by_name)
        found += _fast_to_ask(scene, by_name)
        found += _of_the_thesis(scene, by_name)
        found += [claim for peer in peers if peer.scene == scene for claim in _beside(peer, by_name, n_threads)]
    return found


def _never_costlier(scene: str, rows: dict[str, Row]) -> Iterator[Claim]:
    for kind, least in LEAST.items():
        named = [row for row in rows.values() if row.builder in THESIS_METHODS and row.kind == kind]
        if named:
            best = min(named, key=lambda row: row.thesis_cost)
            of = ", ".join(row.builder for row in named)
            value = rows[least].thesis_cost if least in rows else None
            yield Claim(scene, f"{least} costs no more than any of {of} ({best.builder})", value, best.thesis_cost)


def _fast_to_ask(scene: str, rows: dict[str, Row]) -> Iterator[Claim]:
    others = [row for row in rows.values() if row.builder != QUERIES]
    if not others:
        return
    fastest = min(others, key=lambda row: row.query_ns)
    value = rows[QUERIES].query_ns if QUERIES in rows else None
    yield Claim(
        scene,
        f"ns a ray of {QUERIES}: within 2 % of the fastest other ({fastest.builder})",
        value,
        NEAR * fastest.query_ns,
    )


def _of_the_thesis(scene: str, rows: dict[str, Row]) -> Iterator[Claim]:
    segments = next(iter(rows.values())).n_segments
    for name, n, builder, bound in COSTS:
        if (scene, segments) == (name, n) and builder in rows:
            yield Claim(scene, f"{builder} costs at most {bound:g}", rows[builder].thesis_cost, bound)
    for builder, other, share in SHARES:
        if (scene, segments) == COSTS[0][:2] and builder in rows:
            at_most = rows[other].build_s * share if other in rows else None
            yield Claim(scene, f"s to build {builder}: {share:.2g} of {other}", rows[builder].build_s, at_most)


def _beside(peer: Peer, rows: dict[str, Row], n_threads: int) -> Iterator[Claim]:
    if QUERIES not in rows:
        return
    row = rows[QUERIES]
    yield Claim(peer.scene, f"s to build {QUERIES}: no more than Embree ({peer.config})", row.build_s, peer.build_s)
    if n_threads == 2 and row.n_segments >= LARGE:
        yield Claim(peer.scene, f"s to build {QUERIES}: half of Embree ({peer.config})", row.build_s, peer.build_s / 2)
