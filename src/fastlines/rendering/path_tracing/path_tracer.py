"""Path tracing of hair: light that is scattered many times, by queries of all paths at once.

`cpp/fastlines/shading/paths.hpp` has the integral and its sources. Compiled code scatters the light of one bounce at
the vertices of all paths. Queries of the tree find what hides the lights and what the rays hit next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from ...camera import Vector
from ...engines import engine
from ...support.computed_once import computed_once
from ..hair import HairMaterial
from ..sampling.sampler import Sampler
from ..shading.shading_context import ShadingContext
from .leaving_rays import LeavingRays
from .path_vertices import LEAST, PathVertices
from .secondary_rays import next_vertices, unoccluded

#: The reflectance of what is not a line, such as the skin below the hair.
SKIN = (0.42, 0.27, 0.20)


@dataclass(frozen=True)
class PathTracer:
    """Traces paths through a scene.

    Attributes
    ----------
    context : ShadingContext
    material : HairMaterial
        Of lines.
    max_bounces : int
        How often light is scattered at most.
    skin : (3,) floats
        The reflectance of surfaces without an axis, which scatter evenly.
    """

    context: ShadingContext
    material: HairMaterial
    max_bounces: int
    skin: Vector = SKIN

    def light(self, vertices: PathVertices, sampler: Sampler) -> FloatArray:
        """Return the light that goes from vertices to the eye, (n, 3): of one path each."""
        light = np.zeros((len(vertices), 3), np.float32)
        weight = np.ones_like(light)
        path = np.arange(len(vertices))
        dimension = sampler.dimension
        for bounce in range(self.max_bounces):
            if not len(path):
                break
            step, paths = (sampler.index, dimension, bounce), (path, weight, sampler.seeds)
            shadows, onward, dimension = engine.scatter_paths(self._scene, step, vertices.columns, paths)
            # Gather the light of the lights.
            for vertex, points, directions, start, offered in shadows:
                free = unoccluded(self.context, _leaving(vertices, vertex, points, directions, start))
                engine.add_offered(light, path, vertex, offered, free)
            # Leave the scene, or go on.
            vertex, points, directions, start, weight = onward
            path = path[vertex]
            rows, vertices = next_vertices(self.context, _leaving(vertices, vertex, points, directions, start))
            away = np.ones(len(path), bool)
            away[rows] = False
            engine.add_sky(light, path, weight, directions, away, self.context.sky)
            path, weight = path[rows], weight[rows]
        return light

    @computed_once
    def _scene(self) -> tuple[FloatArray, tuple[float, ...], Vector, float]:
        """The lights and the materials, as compiled code takes them."""
        lights = self.context.lamps
        return lights, self.material.numbers, self.skin, LEAST * self.context.extent


def _leaving(
    vertices: PathVertices, rows: IntArray, points: FloatArray, directions: FloatArray, start: FloatArray
) -> LeavingRays:
    """Return rays that leave some of the vertices."""
    return LeavingRays(points, directions, start, vertices.prim[rows], vertices.strand[rows])
