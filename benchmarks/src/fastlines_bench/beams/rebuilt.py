"""Gathers over a tree of ours and over a scene of Embree, which holds one radius: both built, timed and compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.clock import clock, timed
from ..peers.embree import QUALITIES, Config, Scenes
from .cube import Cube
from .tuned import TRIED, fastest, tune_embree

#: The largest `difference` of two sides that is wanted.
MOST_DIFFERENT = 1e-4


@dataclass(frozen=True)
class Timed:
    """The seconds of a build (0 if nothing was built) and of a gather, and its sums."""

    build_s: float
    gather_s: float
    sums: Any

    @property
    def seconds(self) -> float:
        """The seconds of both."""
        return self.build_s + self.gather_s


def build_tree(cube: Cube, method: str, n_threads: int) -> tuple[fl.Tree, float]:
    """Build our tree with its layout; return the seconds, too."""

    def build() -> fl.Tree:
        tree = fl.build(cube.lines, method)
        tree.layout  # noqa: B018
        return tree

    return timed(build, clock(n_threads))()


def gather_ours(cube: Cube, radius: float, method: str, n_threads: int) -> Timed:
    """Build our tree, and gather once."""
    tree, build_s = build_tree(cube, method, n_threads)
    given = cube.gathering(radius)
    sums, gather_s = timed(partial(given.ours, tree, cube.rays, cube.powers), clock(n_threads))()
    return Timed(build_s, gather_s, sums)


def gather_embree(cube: Cube, radius: float, config: Config, n_threads: int) -> Timed:
    """Build Embree's scene for a radius, and gather once."""
    scenes = Scenes(cube.lines, radius, (0, 0, 0), n_threads)
    build_s = scenes.build_seconds(config.build)
    given = cube.gathering(radius)
    sums, gather_s = timed(partial(scenes.gather, config, given, cube.rays, cube.powers), clock(n_threads))()
    return Timed(build_s, gather_s, sums)


def best_method(cube: Cube, radius: float, methods: Sequence[str], n_threads: int) -> str:
    """Return the method whose tree is built, and gathers all rays, soonest; a part of the rays stands for all."""
    given, few = cube.gathering(radius), cube.rays.part(TRIED)
    seconds = {}
    for method in methods:
        tree, build_s = build_tree(cube, method, n_threads)
        gather = timed(partial(given.ours, tree, few, cube.powers), clock(n_threads))
        takes = [gather()[1] for _ in range(2)]
        seconds[method] = build_s + min(takes) * len(cube.rays) / len(few)
    return min(seconds, key=lambda method: seconds[method])


def best_config(cube: Cube, radius: float, n_threads: int) -> Config:
    """Return the configuration of Embree that is built, and gathers all rays, soonest."""
    tried = tune_embree(cube, cube.gathering(radius), n_threads, QUALITIES[:2])  # high is for spatial splits
    found: Config = fastest(tried, with_build=True).choice
    return found


def difference(mine: Any, theirs: Any) -> float:
    """Return the sum of all absolute differences, by the sum of ours."""
    return float(np.abs(mine - theirs).sum() / max(np.abs(mine).sum(), 1e-300))
