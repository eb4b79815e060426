"""All hits as the thesis took them from Embree: first hits, again and again, each from just behind the last."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..harness.clock import clock
from ..harness.rays import RayBatch
from .embree import Config, Scenes

#: The next search begins so far behind a hit, as a fraction of its distance: a few times what rounding moves it.
STEP = 2.0**-19


@dataclass(frozen=True)
class Repeated:
    """What was found, and the seconds that Embree took; sorting out which rays go on does not count."""

    n_hits: int
    seconds: float


def repeat_first(scenes: Scenes, config: Config, rays: RayBatch) -> Repeated:
    """Ask for first hits until no ray hits anything more.

    Hits so near behind another that the next search begins beyond them are lost. That is the method's own fault, and
    why it is not ours.

    Parameters
    ----------
    scenes : Scenes
    config : Config
        Not of user geometry, whose hits count within the radius of where a search begins: the same one would be found
        for ever.
    rays : RayBatch
    """
    now = clock(scenes.n_threads)
    origins, directions = rays.origins, rays.directions
    at = np.zeros(len(rays), np.float64)
    n_hits, seconds = 0, 0.0
    while len(origins):
        # From the same origin each search would begin at another t, which a batch can not say.
        starts = (origins + at[:, None] * directions).astype(np.float32)
        batch = replace(rays, origins=starts, directions=directions)
        start = now()
        t, prim = scenes.ask(config, "first", batch)
        seconds += now() - start
        hit = prim >= 0
        n_hits += int(hit.sum())
        at = (at[hit] + t[hit]) * (1 + STEP)
        origins, directions = origins[hit], directions[hit]
    return Repeated(n_hits, seconds)
