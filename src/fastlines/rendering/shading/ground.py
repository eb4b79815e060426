"""The ground below the lines, which is seen only by the shadow on it."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...support.vectors import dot
from ..sampling.sampler import Sampler
from .lighting import hemisphere
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
        """Return how dark the ground is where rays with unit directions see it behind lines, (n,); 0 where they do not."""
        context = self.context
        dark = np.zeros(len(directions), np.float32)
        numbers = sampler.next_2d(), sampler.next_2d()
        sinking = -(directions @ context.up)
        above = origins @ context.up - np.float32(self.height)
        rows = np.flatnonzero((sinking > 1e-3) & (above > 0) & (opacity < 1))
        points = np.asarray(origins[rows] + (above[rows] / sinking[rows])[:, None] * directions[rows], np.float32)
        away = points - self.middle
        fade = np.exp(-dot(away, away) / (FADE * max(context.size, context.radius, 1e-15)) ** 2)
        near = fade > 0.01
        rows, points, fade = rows[near], points[near], fade[near]
        no_key = np.zeros(len(rows), np.bool_)
        if context.rig.lights:
            key = context.rig.lights[0].sample(context.camera, *(each[rows] for each in numbers[0]))
            no_key = ~context.unoccluded(points, key)
        up = np.broadcast_to(context.up, points.shape)
        sky = hemisphere(up, *(each[rows] for each in numbers[1]))
        no_sky = ~context.unoccluded(points, sky, NEAR * context.size)
        dark[rows] = fade * (KEY * no_key + SKY * no_sky) * (1 - opacity[rows])
        return dark
