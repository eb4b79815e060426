"""The findings of the thesis (§6), as inequalities that apply to its own tables and to ours.

The thesis does not define "collapses" by a number. Here a tree collapses if it costs more than three times as much as
the D2 tree of its kind, whose constants are the same. Embree collapses if it costs three times as much as with segments
cut, and takes three times as long for first hits.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from fastlines.scenes import NAMES, make

from ..harness.findings import Check, Finding
from .rows import TITLES, Row

#: By scene, then by the name of the row.
Tables: TypeAlias = Mapping[str, Mapping[str, Row]]

COLLAPSED = 3.0
#: "About half" of a time is no more than this; in the thesis it is 0.45 to 0.6 at the radii M and N.
ABOUT_HALF = 0.6
#: SS is "a little better" than CL if it saves up to this share of the cost; D2 "changes little" if it is within LITTLE.
A_LITTLE, LITTLE = 1 / 3, 0.05
HAIR = ("bun-hair", "straight-hair")
#: The D2 tree with which each other tree is compared.
MEASURE = {"bvh-cl": "bvh-d2", "bvh-ss": "bvh-d2", "kd-cl": "kd-d2"}

#: The tree that differs from each D2 tree only by the lookahead.
LEVEL_LESS = {"bvh-d2": "bvh-ss", "kd-d2": "kd-cl"}

_SCENES = {name: make(name, 1).title for name in NAMES}
_COLUMNS = {"cost": "cost", "n_nodes": "nodes"} | {
    f"{query} {letter}": f"time of {query} hits {letter}" for query in ("first", "all") for letter in "MN"
}


def findings_of(tables: Tables) -> list[Finding]:
    """Return all findings for some tables; checks of missing scenes or rows are not measured."""

    def check(scene: str, column: str, of: str, to: str, least: float = 0.0, most: float = float("inf")) -> Check:
        what = f"{_SCENES[scene]}: {_COLUMNS[column]} of {TITLES[of]} / {TITLES[to]}"
        return Check(what, ratio(tables.get(scene, {}), column, of, to), most, least)

    def costs(scene: str, of: str, to: str, least: float, most: float) -> Check:
        return check(scene, "cost", of, to, least, most)

    def collapse(scene: str, tree: str, collapses: bool) -> Check:
        bounds = {"least": COLLAPSED} if collapses else {"most": COLLAPSED}
        return check(scene, "cost", tree, MEASURE[tree], **bounds)

    return [
        Finding("All trees are fine on hair.", tuple(collapse(s, t, False) for s in HAIR for t in MEASURE)),
        Finding(
            "BVH::SS is a little better than BVH::CL on hair.",
            tuple(costs(scene, "bvh-ss", "bvh-cl", 1 - A_LITTLE, 0.9999) for scene in HAIR),
        ),
        Finding(
            "D2 changes little on hair.",
            tuple(costs(s, d2, of, 1 - LITTLE, 1 + LITTLE) for s in HAIR for d2, of in LEVEL_LESS.items()),
        ),
        Finding(
            "BVH::CL, BVH::SS and KD::CL collapse on spaghetti.",
            tuple(collapse("spaghetti", tree, True) for tree in MEASURE),
        ),
        Finding(
            "Only the D2 trees and Embree PS survive spaghetti 2.",
            (
                *(collapse("spaghetti-2", tree, True) for tree in MEASURE),
                check("spaghetti-2", "cost", "embree", "embree-ps", least=COLLAPSED),
                check("spaghetti-2", "first M", "embree", "embree-ps", least=COLLAPSED),
            ),
        ),
        Finding(
            "Only BVH::CL fails on photon beams.",
            tuple(collapse("photon-beams", tree, tree == "bvh-cl") for tree in MEASURE),
        ),
        Finding(
            "KD trees have many nodes and a low cost.",
            tuple(
                each
                for scene in _SCENES
                for each in (
                    check(scene, "n_nodes", "kd-d2", "bvh-d2", least=2.0),
                    costs(scene, "kd-d2", "bvh-d2", 0.0, 0.75),
                )
            ),
        ),
        Finding(
            "KD trees take about half of BVHs’ time.",
            tuple(
                check(scene, column, "kd-d2", "bvh-d2", most=ABOUT_HALF)
                for scene in _SCENES
                for column in ("first M", "first N", "all M", "all N")
            ),
        ),
    ]


def ratio(rows: Mapping[str, Row], column: str, of: str, to: str) -> float | None:
    """Return a figure of row `of` divided by that of row `to`; None if one is missing or `to` did not finish."""
    a, b = (rows[name].figure(column) if name in rows else None for name in (of, to))
    return a / b if a is not None and b and b < float("inf") else None
