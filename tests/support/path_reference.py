"""One bounce of path tracing in NumPy, which the compiled one is compared with.

It is no part of the package: `cpp/fastlines/shading/paths.hpp` states what it computes, and nothing else needs it.
"""

from __future__ import annotations

import numpy as np

from fastlines.rendering import hair
from fastlines.rendering.sampling.sobol import hashed, uniforms
from fastlines.rendering.shading.lighting import hemisphere
from fastlines.support.vectors import dot, is_zero, unit

EVEN_DIMENSIONS = 24
FAINT = 1 / 64
SURE_BOUNCES = 3
STEEPEST, MARGIN = 0.05, 0.02


class Numbers:
    """The random numbers of paths, one dimension of the sample after another."""

    def __init__(self, index, seeds, dimension):
        self.index, self.seeds, self.dimension = index, seeds, dimension

    def take(self, count):
        first = self.dimension
        self.dimension += count + count % 2
        if self.dimension <= EVEN_DIMENSIONS:
            return [uniforms(self.index, self.seeds, first + i) for i in range(count)]
        seeds = hashed(self.seeds + hashed(np.full(1, self.index, np.uint32)))
        return [(hashed(seeds, first + i) >> np.uint32(8)) * np.float32(2.0**-24) for i in range(count)]


class Bounce:
    """What light does at vertices: offers of lights, directions that go on, and their weights.

    Attributes
    ----------
    offers : list of (towards, light, is_offered)
        Of each light, or of the one that is chosen; the light includes the weight of the path.
    towards, weight : (n, 3)
    lasts : (n,) bool
        Which paths go on.
    """

    def __init__(self, vertices, weight, numbers, bounce, rig, camera, material, skin):
        self.bare = is_zero(vertices.tangents)
        self.vertices, self.material, self.skin = vertices, material, np.float32(skin)
        self.offers = []
        for lamp in rig.lights:
            towards = lamp.sample(camera, *numbers.take(2))
            self.offers.append((towards, self._evaluate(towards) * np.float32(lamp.color)))
        choice, chance = numbers.take(2)
        if bounce and len(rig.lights) > 1:
            self.offers = [self._chosen(choice)]
        faint = FAINT * max((max(light.color) for light in rig.lights), default=1)
        self.offers = [(towards, *self._of_faint(weight * light, chance, faint)) for towards, light in self.offers]
        self._go_on(numbers.take(4), numbers.take(1)[0], weight, bounce)

    @property
    def _rays(self):
        vertices = self.vertices
        side = unit(np.cross(vertices.to_eye, vertices.tangents))
        return vertices.to_eye, vertices.tangents, np.clip(dot(vertices.normals, side), -1, 1)

    def _evaluate(self, towards):
        to_eye, tangents, h = (np.float64(each) for each in self._rays)
        with np.errstate(invalid="ignore"):
            value = hair.evaluate(self.material, to_eye, np.float64(towards), tangents, h)
        facing = np.maximum(dot(self.vertices.normals, towards), 0)[:, None]
        return np.where(self.bare[:, None], facing * self.skin / np.pi, value)

    def _chosen(self, u):
        sums = np.cumsum([light.sum(axis=1) for _, light in self.offers], axis=0)
        chosen = (u * sums[-1] >= sums[:-1]).sum(axis=0)[:, None]
        towards = np.choose(chosen, [towards for towards, _ in self.offers])
        light = np.choose(chosen, [light for _, light in self.offers])
        with np.errstate(invalid="ignore", divide="ignore"):
            return towards, np.nan_to_num(light * (sums[-1] / light.sum(axis=1))[:, None])

    @staticmethod
    def _of_faint(light, chance, faint):
        likely = np.minimum(light.max(axis=1) / faint, 1)
        return light / np.maximum(likely, 1e-30)[:, None], chance < likely

    def _go_on(self, u, chance, weight, bounce):
        to_eye, tangents, h = (np.float64(each) for each in self._rays)
        with np.errstate(invalid="ignore"):
            towards, change, _ = hair.sample(self.material, to_eye, tangents, h, np.stack(u, axis=1).astype(np.float64))
        bare = self.bare[:, None]
        self.towards = np.where(bare, hemisphere(self.vertices.normals, u[0], u[1]), towards)
        weight = weight * np.where(bare, self.skin, change)
        lasting = np.minimum(weight.max(axis=1), 1) if bounce >= SURE_BOUNCES else np.ones(len(weight))
        self.lasts = chance < lasting
        self.weight = weight / lasting[:, None]

    def exits(self, towards, least):
        """Return how far rays are within the fibre that they leave, and `least` more."""
        vertices = self.vertices
        across = towards - dot(towards, vertices.tangents)[:, None] * vertices.tangents
        away = vertices.normals - dot(vertices.normals, vertices.tangents)[:, None] * vertices.tangents
        steep, outwards = np.maximum(dot(across, across), STEEPEST**2), dot(away, across)
        chord = (np.sqrt(outwards**2 + steep * np.maximum(1 - dot(away, away), 0)) - outwards) / steep
        return np.where(self.bare, 0, (chord + MARGIN) * vertices.radius) + least
