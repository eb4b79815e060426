"""Steps of the report: Embree as the thesis asked it, whole and with segments cut to the length that suits it.

The thesis gave Embree two triangles a segment that face the camera, asked ray by ray, and took all hits by repeated
first hits. Here these are kept, and beside them all hits in one pass, by a filter.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..harness.compare import compare
from ..harness.rays import RayBatch, camera_rays
from ..harness.store import Found
from ..harness.subjects import Subject
from ..harness.turns import ask_tree
from ..package import num_threads
from ..peers.embree import Build, Config, Scenes
from ..peers.embree_tree import embree_tree
from ..peers.repeat import repeat_first
from ..peers.tuning import MAX_PIECES
from .measure import Asked, measure, some, timed_by
from .preset import ThesisPreset
from .trees import CHECKED


def ribbons(length: float) -> Config:
    """Two triangles a piece that face the camera, without spatial splits, which would report some twice; ray by ray."""
    return Config(Build("ribbon", length, high_quality=False), width=1)


def sweep_step(subject: Subject, preset: ThesisPreset) -> Found:
    """Cut segments to several lengths, and find the one with which first and all hits together are fastest."""
    ends = subject.lines.segments.astype(np.float64)
    total = float(np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1)).sum())
    rays = camera_rays(subject.camera, preset.size**2)
    found: list[dict[str, Any]] = []
    for share in preset.lengths:
        length = share * subject.diagonal
        if length and len(subject.lines) + total / length > MAX_PIECES:
            continue
        config = ribbons(length)
        scenes = Scenes(subject.lines, subject.by_letter["M"], subject.camera.origin, 1)
        first, every = (
            measure(_asked(scenes, config, query), query, rays, preset.budget / 2) for query in ("first", "all")
        )
        scene = scenes.get(config.build)
        found.append(
            {
                "share": share,
                "length": length,
                "n_pieces": scene.n_pieces,
                "build_s": scenes.build_seconds(config.build),
                "first M": first.to_json(),
                "all M": every.to_json(),
                "mean_ms": math.sqrt(first.ms * every.ms),
            }
        )
    best = min(found, key=lambda each: each["mean_ms"])
    return {"lengths": found, "best": best["length"], "best_share": best["share"]}


def embree_step(subject: Subject, preset: ThesisPreset, length: float) -> Found:
    """Build Embree's scenes, one for each radius, and ask them."""
    config = ribbons(length)
    rays = camera_rays(subject.camera, preset.size**2)
    few = some(rays, CHECKED)
    found: Found = {"times": {}, "piece_length": length}
    for letter, radius in subject.by_letter.items():
        scenes = Scenes(subject.lines, radius, subject.camera.origin, 1)
        asked = {
            "first": _asked(scenes, config, "first"),
            "all": _repeating(scenes, config),
            "filter": _asked(scenes, config, "all"),
        }
        for name, ask in asked.items():
            timed = measure(ask, "first" if name == "first" else "all", rays, preset.budget)
            found["times"][f"{name} {letter}"] = timed.to_json()
        if letter == "M":
            scene = scenes.get(config.build)
            found |= {
                "n_prims": scene.n_pieces,
                "build_s": scenes.build_seconds(config.build),
                "memory_bytes": scene.bytes,
            }
            found["differs"] = _differences(subject, scenes, config, few)
    return found


def embree_tree_step(subject: Subject, length: float) -> Found:
    """Build trees of the whole segments and of the pieces by Embree's builder interface, and tell their figures.

    Its callbacks are Python, so there are none of more pieces than the sweep allows.
    """
    if len(subject.lines) > MAX_PIECES:
        return {"embree": {}, "embree-ps": {}}
    trees = {"embree": embree_tree(subject.lines), "embree-ps": embree_tree(subject.lines, length)}
    return {name: {"n_nodes": tree.n_nodes, "cost": tree.cost} for name, tree in trees.items()}


def _asked(scenes: Scenes, config: Config, query: str) -> Asked:
    def count(answer: Any) -> int:
        return len(answer.unpack()[0]) if query == "all" else int((answer[1] >= 0).sum())

    scenes.get(config.build)
    return timed_by(lambda rays: scenes.ask(config, query, rays), count)


def _repeating(scenes: Scenes, config: Config) -> Asked:
    scenes.get(config.build)

    def ask(rays: RayBatch) -> tuple[int, float]:
        repeated = repeat_first(scenes, config, rays)
        return repeated.n_hits, repeated.seconds

    return ask


def _differences(subject: Subject, scenes: Scenes, config: Config, rays: RayBatch) -> dict[str, float]:
    """Which share of the rays gets another answer than ours, and how many hits repeating finds of those by filter."""
    shares = {}
    with num_threads(1):
        for query in ("first", "all"):
            ours = ask_tree(subject.best, query, rays, scenes.radius)
            shares[query] = compare(query, ours, scenes.ask(config, query, rays)).share
    by_filter = len(scenes.ask(config, "all", rays).unpack()[0])
    return {**shares, "repeated": repeat_first(scenes, config, rays).n_hits / max(1, by_filter)}
