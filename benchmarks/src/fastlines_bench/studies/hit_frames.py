"""How long it takes to say where hits are, beside the query that found them: points, normals, tangents and radii."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import fastlines as fl
from fastlines.threads import num_threads

from ..harness.clock import best_of
from ..harness.rays import camera_rays, rays_through

ROUNDS = 5

#: The radius of hair, in the unit of the scene.
RADIUS = 0.001


def bun_hair(segments: int) -> dict[str, fl.Lines | fl.Curves]:
    """Return bun hair of some number of segments, with a radius, as lines and as curves through the same points."""
    lines = fl.scenes.make("bun-hair", segments).lines
    counts = np.unique(lines.strands, return_counts=True)[1]
    ends = np.cumsum(counts)
    points = np.insert(lines.segments[:, 0], ends, lines.segments[ends - 1, 1], axis=0)
    curves = fl.Curves.from_strands(points, counts + 1, basis="catmull-rom", wrap="pinned", radius=RADIUS)
    return {"lines": lines.with_radius(np.full((len(lines), 2), RADIUS, np.float32)), "curves": curves}


def print_hit_frames(segments: int, n_rays: int, n_threads: int) -> None:
    """Print nanoseconds for each hit, for rays of a camera and for random rays."""
    answers: dict[str, Callable[[fl.FirstHits], Any]] = {
        "`points()`": lambda hits: hits.points(),
        "`normals()`": lambda hits: hits.normals(),
        "`tangents()`": lambda hits: hits.tangents(),
        '`sample("radius")`': lambda hits: hits.sample("radius"),
        "`points(outside=True)`": lambda hits: hits.points(outside=True),
        "`frames()`": lambda hits: hits.frames(),
    }
    camera = fl.scenes.make("bun-hair", segments).camera
    columns: dict[str, list[float]] = {}
    with num_threads(n_threads):
        for name, geometry in bun_hair(segments).items():
            tree = fl.build(geometry)
            for rays in (camera_rays(camera, n_rays), rays_through(geometry.bounds, n_rays)):
                ask = partial(tree.first_hit, rays.origins, rays.directions, at="surface")
                query, hits = best_of(ROUNDS, n_threads, ask)
                seconds = [query, *(best_of(ROUNDS, n_threads, partial(of, hits))[0] for of in answers.values())]
                columns[f"{name}, {rays.kind}"] = [1e9 * each / max(1, int(hits.hit.sum())) for each in seconds]
    print(f"| ns a hit | {' | '.join(columns)} |\n|---|{'--:|' * len(columns)}")
    for name, *cells in zip(["the query", *answers], *columns.values(), strict=True):
        print(f"| {name} | {' | '.join(f'{cell:.0f}' for cell in cells)} |")
