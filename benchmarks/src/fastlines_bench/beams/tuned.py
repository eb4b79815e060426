"""The fastest settings of the peers for a gather: trials on a part of the rays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..harness.clock import clock, timed
from ..peers.beam_loops import BeamGrid
from ..peers.embree import Build, Scenes, configs
from ..peers.gathering import Gathering
from .cube import Cube

#: The lengths of Embree's pieces, as shares of the box's diagonal; 0 = whole beams.
PIECES = (0.0, 1 / 8, 1 / 16, 1 / 32, 1 / 64)

#: The most pieces, and the most references of a grid.
MAX_PIECES, MAX_REFS = 8_000_000, 150_000_000

#: The cells of a grid along its longest side.
RESOLUTIONS = (16, 32, 64, 128, 256)

#: The rays of a trial.
TRIED = 1 << 11


@dataclass(frozen=True)
class Tuned:
    """What is fastest, the seconds of its build in the trial, and those of a gather, scaled to all rays."""

    choice: Any
    build_s: float
    gather_s: float


def fastest(found: Sequence[Tuned], with_build: bool = False) -> Tuned:
    """Return the settings whose gather, or whose build and gather, take the least time."""
    return min(found, key=lambda each: each.gather_s + with_build * each.build_s)


def tune_embree(
    cube: Cube, given: Gathering, n_threads: int, qualities: Sequence[str], built_for: float | None = None
) -> list[Tuned]:
    """Try configurations of Embree's user geometry; return them all.

    All widths of packets are tried on whole beams, and the fastest one on pieces.
    """
    length, diagonal = _total_length(cube), float(np.linalg.norm(np.ptp(cube.lines.bounds, axis=0)))
    found: list[Tuned] = []
    few = cube.rays.part(TRIED)
    for quality in qualities:
        for share in PIECES:
            piece = share * diagonal
            if piece and len(cube.lines) + length / piece > MAX_PIECES:
                continue
            build = Build("user", piece, quality)
            scenes = Scenes(cube.lines, given.radius, (0, 0, 0), n_threads, built_for)
            tried = [fastest(found).choice] if piece else configs(scenes, [build], "all", few)
            for config in (replace(each, build=build) for each in tried):
                took = _trial(partial(scenes.gather, config, given, few, cube.powers), n_threads)
                found.append(Tuned(config, scenes.build_seconds(build), took * len(cube.rays) / len(few)))
    return found


def tune_grid(cube: Cube, given: Gathering, n_threads: int) -> list[Tuned]:
    """Try all resolutions of a grid; return them all."""
    side = float(np.ptp(cube.lines.bounds, axis=0).max())
    found, few = [], cube.rays.part(TRIED)
    for resolution in RESOLUTIONS:
        if 2 * _total_length(cube) / side * resolution > MAX_REFS:
            continue
        grid, built = timed(partial(BeamGrid, cube.lines, given.radius, resolution), clock(n_threads))()
        took = _trial(partial(grid.gather, given, few, cube.powers, n_threads), n_threads)
        found.append(Tuned(resolution, built, took * len(cube.rays) / len(few)))
    return found


def _trial(do: Callable[[], Any], n_threads: int) -> float:
    """Return the least seconds of two calls."""
    return min(timed(do, clock(n_threads))()[1] for _ in range(2))


def _total_length(cube: Cube) -> float:
    edges = (cube.lines.segments[:, 1] - cube.lines.segments[:, 0]).astype(np.float64)
    return float(np.sqrt((edges**2).sum(axis=1)).sum())
