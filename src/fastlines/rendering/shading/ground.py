"""The ground below the lines, which is seen only by the shadow on it."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...engines import engine
from ...support.vectors import dot
from ..sampling.sampler import Sampler
from .shading_context import ShadingContext

#: How much darker the ground is where the key light, and where the sky, is hidden.
KEY, SKY = 0.35, 0.35
#: The sky is hidden by what is nearer than this fraction of the size of the scene.
NEAR = 0.25
#: The shadow fades at about this distance from below the middle, in sizes of the scene.
FADE = 0.6


class Ground:
    """A plane through the lowest point of the geometry."""

    def __init__(self, context: ShadingContext) -> None:
        self.context = context
        box = context.tree.box.astype(np.float64)
        self.middle = box.mean(axis=0)
        lowest = float((self.middle - np.abs(context.up) * (box[1] - box[0]) / 2) @ context.up)
        self.height = lowest - context.radius - context.tree.geometry.max_radius

    def darkness(
        self, origins: FloatArray, directions: FloatArray, opacity: FloatArray, sampler: Sampler
    ) -> FloatArray:
        """Return how dark the ground is where rays with unit directions hit it, behind lines, (n,); else 0."""
        context = self.context
        dark = np.zeros(len(directions), np.float32)
        sinking = -(directions @ context.up)
        above = origins @ context.up - np.float32(self.height)
        rows = np.flatnonzero((sinking > 1e-3) & (above > 0) & (opacity < 1))
        points = np.asarray(origins[rows] + (above[rows] / sinking[rows])[:, None] * directions[rows], np.float32)
        away = points - self.middle
        fade = np.exp(-dot(away, away) / (FADE * max(context.size, context.radius, 1e-15)) ** 2)
        near = fade > 0.01
        rows, points, fade = rows[near], points[near], fade[near]
        up = np.broadcast_to(context.up, points.shape).copy()
        numbers = sampler.index, sampler.seeds[rows], sampler.dimension
        chalk = np.ones_like(up), False, (1.0, 1.0, 0.0, 0.0)
        (key, light), (sky, _), _ = engine.light_of_solids((up, up), *chalk, context.lamps[:1], context.sky, numbers)
        no_key = np.zeros(len(rows), np.bool_)
        lit = np.flatnonzero(light.any(axis=1))
        no_key[lit] = ~context.unoccluded(points[lit], key[lit])
        no_sky = ~context.unoccluded(points, sky, NEAR * context.size)
        dark[rows] = fade * (KEY * no_key + SKY * no_sky) * (1 - opacity[rows])
        return dark
