"""All hits by repeated first hits, each from just behind the last one, as the thesis queried Embree."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..harness.clock import clock
from ..harness.rays import RayBatch
from .embree import Config, Scenes

#: The offset of the next origin behind a hit, as a fraction of its distance: a few times the rounding error.
STEP = 2.0**-19


@dataclass(frozen=True)
class Repeated:
    """The number of hits, and the seconds of Embree's calls alone."""

    n_hits: int
    seconds: float


def repeat_first(scenes: Scenes, config: Config, rays: RayBatch) -> Repeated:
    """Query first hits until no ray hits anything more; return the number of hits and the time.

    The method misses hits that are nearer to another hit than the offset of the next origin.

    Parameters
    ----------
    scenes : Scenes
    config : Config
        A configuration without user geometry. There, rays hit segments within the radius of their origin, so the same
        hit would be found forever.
    rays : RayBatch
    """
    now = clock(scenes.n_threads)
    origins, directions = rays.origins, rays.directions
    at = np.zeros(len(rays), np.float64)
    n_hits, seconds = 0, 0.0
    while len(origins):
        # Move the origins, because all rays of a batch have the same t_min.
        starts = (origins + at[:, None] * directions).astype(np.float32)
        batch = replace(rays, origins=starts, directions=directions)
        start = now()
        t, prim = scenes.query(config, "first", batch)
        seconds += now() - start
        hit = prim >= 0
        n_hits += int(hit.sum())
        at = (at[hit] + t[hit]) * (1 + STEP)
        origins, directions = origins[hit], directions[hit]
    return Repeated(n_hits, seconds)
