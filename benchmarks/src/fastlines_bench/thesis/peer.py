"""Steps of the report: Embree as in the thesis, with whole segments and with segments cut to the best length.

The thesis gave Embree two triangles per segment that face the camera, queried it ray by ray, and found all hits by
repeated first hits. These steps do the same, and also find all hits in one pass by a filter.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..builders.names import THESIS_COST
from ..harness.compare import compare
from ..harness.internals import num_threads
from ..harness.rays import RayBatch, camera_rays
from ..harness.subjects import Subject
from ..harness.turns import query_tree
from ..peers.embree import Build, Config, Scenes
from ..peers.embree_tree import embree_tree
from ..peers.repeat import repeat_first
from ..peers.tuning import MAX_PIECES
from .measure import TimedQuery, measure, some, timed_by
from .preset import ThesisPreset
from .store import Found
from .trees import CHECKED


def ribbons(length: float) -> Config:
    """Return the thesis's configuration: ribbons, ray by ray, without spatial splits, which report some hits twice."""
    return Config(Build("ribbon", length, quality="medium"), width=1)


def sweep_step(subject: Subject, preset: ThesisPreset) -> Found:
    """Time first and all hits with segments cut to several lengths; return the times and the best length."""
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
            measure(_timed(scenes, config, query), query, rays, preset.budget / 2) for query in ("first", "all")
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
    """Build Embree's scenes, one for each radius, and time their queries."""
    config = ribbons(length)
    rays = camera_rays(subject.camera, preset.size**2)
    few = some(rays, CHECKED)
    found: Found = {"times": {}, "piece_length": length}
    for letter, radius in subject.by_letter.items():
        scenes = Scenes(subject.lines, radius, subject.camera.origin, 1)
        runs = {
            "first": _timed(scenes, config, "first"),
            "all": _repeating(scenes, config),
            "filter": _timed(scenes, config, "all"),
        }
        for name, run in runs.items():
            timed = measure(run, "first" if name == "first" else "all", rays, preset.budget)
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
    """Return the figures of the trees that Embree's builder interface builds over whole segments and over pieces.

    Its callbacks are in Python, so scenes with more segments than the sweep allows pieces have no trees.
    """
    if len(subject.lines) > MAX_PIECES:
        return {"embree": {}, "embree-ps": {}}
    model = THESIS_COST["bvh"]
    trees = {"embree": embree_tree(subject.lines, model), "embree-ps": embree_tree(subject.lines, model, length)}
    return {name: {"n_nodes": tree.n_nodes, "cost": tree.cost} for name, tree in trees.items()}


def _timed(scenes: Scenes, config: Config, query: str) -> TimedQuery:
    def count(answer: Any) -> int:
        return len(answer.unpack()[0]) if query == "all" else int((answer[1] >= 0).sum())

    scenes.get(config.build)
    return timed_by(lambda rays: scenes.query(config, query, rays), count)


def _repeating(scenes: Scenes, config: Config) -> TimedQuery:
    scenes.get(config.build)

    def run(rays: RayBatch) -> tuple[int, float]:
        repeated = repeat_first(scenes, config, rays)
        return repeated.n_hits, repeated.seconds

    return run


def _differences(subject: Subject, scenes: Scenes, config: Config, rays: RayBatch) -> dict[str, float]:
    """Return the shares of rays whose answers differ from ours, and the number of repeated hits by the filter's."""
    shares = {}
    with num_threads(1):
        for query in ("first", "all"):
            ours = query_tree(subject.best, query, rays, scenes.radius)
            shares[query] = compare(query, ours, scenes.query(config, query, rays)).share
    by_filter = len(scenes.query(config, "all", rays).unpack()[0])
    return {**shares, "repeated": repeat_first(scenes, config, rays).n_hits / max(1, by_filter)}
