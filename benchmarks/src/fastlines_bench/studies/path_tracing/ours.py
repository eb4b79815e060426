"""Our side: the path tracer of ``fl.render(…, quality="high")``, with a box filter and a clock in the tree."""

from __future__ import annotations

from collections import defaultdict
from functools import partial
from threading import Lock
from time import perf_counter
from typing import Any

import numpy as np

from fastlines import Tree

from ...harness.arrays import FloatArray
from ...harness.internals import (
    PathTracer,
    Rig,
    Sampler,
    ShadingContext,
    Surfaces,
    hashed,
    map_in_threads,
    seen_vertices,
)
from ...peers.hair_scene import HairScene

QUERIES = ("first_surface", "first_hit", "any_hit")


class TimedTree:
    """A tree that counts its rays and their time, and records the rays of some queries.

    Attributes
    ----------
    seconds, rays : dict
        By the name of the query, of all threads together.
    recorded : dict
        Of each query, the origins and directions of the rays, from where they start to count; but for the few rays that
        start in another fibre.
    """

    def __init__(self, tree: Tree) -> None:
        self._tree = tree
        self.seconds: dict[str, float] = defaultdict(float)
        self.rays: dict[str, int] = defaultdict(int)
        self.recorded: dict[str, list[tuple[FloatArray, FloatArray]]] = defaultdict(list)
        self.records = False
        self._lock = Lock()

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._tree, name)
        if name not in QUERIES:
            return found

        def timed(origins: FloatArray, directions: FloatArray, *args: Any, **options: Any) -> Any:
            start = perf_counter()
            hits = found(origins, directions, *args, **options)
            with self._lock:
                self.seconds[name] += perf_counter() - start
                self.rays[name] += len(directions)
            if self.records and "t_max" not in options and options.get("at") != "entry":
                kind = name if "t_min" in options else f"camera {name}"
                moved = origins + np.reshape(options.get("t_min", 0.0), (-1, 1)) * directions
                self.recorded[kind].append((np.asarray(moved, np.float32), directions))
            return hits

        return timed


class OurScene:
    """A scene of hair, rendered by fastlines."""

    def __init__(self, scene: HairScene, tree: Tree) -> None:
        self.scene, self.tree = scene, TimedTree(tree)
        timed: Any = self.tree
        self._context = ShadingContext(
            timed, scene.query_radius, scene.camera, Rig((scene.light,), scene.sky), 0.0, False
        )
        self._tracer = PathTracer(self._context, scene.material, scene.max_bounces)
        self._finder = Surfaces(timed, scene.query_radius)

    def render(self, samples: int, seed: int) -> tuple[FloatArray, float]:
        """Render a picture, (size, size, 3), and return the seconds too."""
        start = perf_counter()
        size = self.scene.size
        light = np.zeros((size * size, 3), np.float64)
        for sample in map_in_threads(partial(self._sample, seed=seed), range(samples)):
            light += sample
        return np.asarray(light / samples, np.float32).reshape(size, size, 3), perf_counter() - start

    def _sample(self, index: int, seed: int) -> FloatArray:
        """Return the light of one ray for each pixel."""
        size = self.scene.size
        pixels = np.arange(size * size)
        seeds = hashed(pixels.astype(np.uint32), seed)
        right, down = Sampler(index, seeds, 0).next_2d()
        x, y = pixels % size + right, pixels // size + down
        origins, directions, _ = self.scene.camera.ray(x, y, size, size)
        fragments = self._finder.find(origins, directions, 0.0)
        light = self._context.rig.sky.radiance(directions @ self._context.up)
        numbers = Sampler(index, seeds[fragments.ray])
        vertices = seen_vertices(fragments, self._context, np.zeros(len(fragments), np.float32))
        light[fragments.ray] = self._tracer.light(vertices, numbers)
        return np.asarray(light)
