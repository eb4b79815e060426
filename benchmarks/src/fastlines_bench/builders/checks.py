"""The expected properties of the builder `best`, as checks of what was measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ..harness.findings import Check
from ..harness.internals import THESIS_METHODS
from .rows import BuilderRow, Peer

#: The builder for queries, and the builders of least cost, by kind.
QUERIES = "best"
LEAST = {"bvh": "best-bvh", "kd": "best-kd"}

#: Bounds of the cost on the thesis's scenes: the scene, its segments, the builder, the bound.
COSTS = (
    ("spaghetti", 2000, "best-bvh", 269.0),
    ("spaghetti", 2000, "best-bvh@1", 262.0),
    ("spaghetti", 2000, "best-kd", 137.6),
    ("spaghetti-2", 8000, "best-bvh", 540.0),
    ("spaghetti-2", 8000, "best-kd", 276.0),
)

#: Bounds of the build time on spaghetti: the builder, another builder, the maximum share of the other's time.
SHARES = (
    ("best-bvh", "bvh-d2", 1 / 3),
    ("best-kd", "kd-d2", 1 / 10),
    ("best-kd", "kd-d2-exhaustive", 1 / 10),
)

#: The bound of the query time of `best`, as a multiple of the fastest of all others.
NEAR = 1.02

#: From this number of segments, a build by two threads takes at most half of Embree's time.
LARGE = 1_000_000


def checks(rows: Sequence[BuilderRow], peers: Sequence[Peer], n_threads: int) -> list[Check]:
    """Return the checks of each scene.

    A check compares with the builders that were built within the time limit, and names them.
    """
    found: list[Check] = []
    for scene in dict.fromkeys(row.scene for row in rows):
        by_name = {row.builder: row for row in rows if row.scene == scene}
        of_scene = [*_never_costlier(by_name), *_fast_queries(by_name), *_of_the_thesis(scene, by_name)]
        of_scene += [check for peer in peers if peer.scene == scene for check in _beside(peer, by_name, n_threads)]
        found += [replace(check, scene=scene) for check in of_scene]
    return found


def _never_costlier(rows: dict[str, BuilderRow]) -> Iterator[Check]:
    for kind, least in LEAST.items():
        named = [row for row in rows.values() if row.builder in THESIS_METHODS and row.kind == kind]
        if named:
            best = min(named, key=lambda row: row.thesis_cost)
            of = ", ".join(row.builder for row in named)
            value = rows[least].thesis_cost if least in rows else None
            yield Check(f"{least} costs no more than any of {of} ({best.builder})", value, best.thesis_cost)


def _fast_queries(rows: dict[str, BuilderRow]) -> Iterator[Check]:
    others = [row for row in rows.values() if row.builder != QUERIES]
    if not others:
        return
    fastest = min(others, key=lambda row: row.query_ns)
    value = rows[QUERIES].query_ns if QUERIES in rows else None
    yield Check(
        f"ns a ray of {QUERIES}: within 2 % of the fastest other ({fastest.builder})",
        value,
        NEAR * fastest.query_ns,
    )


def _of_the_thesis(scene: str, rows: dict[str, BuilderRow]) -> Iterator[Check]:
    segments = next(iter(rows.values())).n_segments
    for name, n, builder, bound in COSTS:
        if (scene, segments) == (name, n) and builder in rows:
            yield Check(f"{builder} costs at most {bound:g}", rows[builder].thesis_cost, bound)
    for builder, other, share in SHARES:
        if (scene, segments) == COSTS[0][:2] and builder in rows:
            at_most = rows[other].build_s * share if other in rows else None
            yield Check(f"s to build {builder}: {share:.2g} of {other}", rows[builder].build_s, at_most)


def _beside(peer: Peer, rows: dict[str, BuilderRow], n_threads: int) -> Iterator[Check]:
    if QUERIES not in rows:
        return
    row = rows[QUERIES]
    yield Check(f"s to build {QUERIES}: no more than Embree ({peer.config})", row.build_s, peer.build_s)
    if n_threads == 2 and row.n_segments >= LARGE:
        yield Check(f"s to build {QUERIES}: half of Embree ({peer.config})", row.build_s, peer.build_s / 2)
