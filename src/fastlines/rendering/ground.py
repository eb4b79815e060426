"""The ground below the lines, which is seen only by the shadow on it."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..geometry import largest_radius
from ..vectors import dot
from .lighting import hemisphere
from .sampler import Sampler
from .stage import Stage

#: How much darker the ground is where the key light, and where the sky, is hidden.
KEY, SKY = 0.35, 0.35
#: The sky is hidden by what is nearer than this fraction of the size of the scene.
NEAR = 0.25
#: The shadow fades at about this distance from below the middle, in sizes of the scene.
FADE = 0.6


class Ground:
    """A plane through the lowest point of the geometry."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        box = stage.tree.nodes["box"][0].astype(np.float64)
        self.middle = box.mean(axis=0)
        lowest = float((self.middle - np.abs(stage.up) * (box[1] - box[0]) / 2) @ stage.up)
        self.height = lowest - stage.radius - largest_radius(stage.tree.geometry)

    def darkness(self, origins: FloatArray, directions: FloatArray, sampler: Sampler) -> FloatArray:
        """Return how dark the ground is where rays with unit directions meet it, (n,); 0 where they do not."""
        stage = self.stage
        dark = np.zeros(len(directions), np.float32)
        numbers = sampler.next_2d(), sampler.next_2d()
        sinking = -(directions @ stage.up)
        above = origins @ stage.up - np.float32(self.height)
        rows = np.flatnonzero((sinking > 1e-3) & (above > 0))
        points = np.asarray(origins[rows] + (above[rows] / sinking[rows])[:, None] * directions[rows], np.float32)
        away = points - self.middle
        fade = np.exp(-dot(away, away) / (FADE * max(stage.size, stage.radius, 1e-15)) ** 2)
        near = fade > 0.01
        rows, points, fade = rows[near], points[near], fade[near]
        key = stage.rig.lights[0].sample(stage.camera, *(each[rows] for each in numbers[0]))
        up = np.broadcast_to(stage.up, points.shape)
        sky = hemisphere(up, *(each[rows] for each in numbers[1]))
        no_key, no_sky = ~stage.unoccluded(points, key), ~stage.unoccluded(points, sky, NEAR * stage.size)
        dark[rows] = fade * (KEY * no_key + SKY * no_sky)
        return dark
