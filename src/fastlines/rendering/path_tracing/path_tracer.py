"""Path tracing: light that is scattered many times, by queries of all paths at once.

Each path starts at a point that the camera sees. At each point it gathers the light that comes straight from a distant
light, and goes on in a direction that is drawn as light is scattered. If it leaves the scene, it gathers the light of
the sky. So

    L(x, ωo) = Σ_lights E S(ωo, ωl) V(x, ωl) + 𝔼[ weight · (L or the sky) ],

where S is the scattering with its cosine, E an irradiance and V the visibility. Paths end by chance, as their weight
falls ("Russian roulette"), so the mean is that of paths without end, up to the greatest number of bounces.

All paths go on side by side (a wavefront): a bounce is one query of the first hits, and one or more of any hits.
Sources: Kajiya, "The Rendering Equation", 1986; Laine et al., "Megakernels Considered Harmful", 2013.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...arrays import AnyArray, FloatArray
from ..sampling.sobol import Words, hashed, uniforms
from ..shading.lighting import Light
from ..shading.shading_context import ShadingContext
from .path_vertices import PathVertices
from .secondary_rays import next_vertices, unoccluded

#: Dimensions of a sample that are evenly distributed; later ones are independent random numbers.
EVEN_DIMENSIONS = 24
#: The number of bounces after which paths end by chance.
SURE_BOUNCES = 3


class Scattering(Protocol):
    """How light is scattered at some vertices."""

    def evaluate(self, towards: FloatArray) -> AnyArray:
        """Return how much of the light from some directions goes to the eye, per steradian, cosine included, (n, 3)."""

    def sample(self, u4: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Draw directions (n, 3), and return their weights (n, 3): `evaluate` by the density."""


class Scatterer(Protocol):
    """How light is scattered."""

    def at(self, vertices: PathVertices) -> Scattering:
        """Return the scattering at some vertices."""


@dataclass
class PathSampler:
    """Uniform random numbers of paths, one dimension of the sample after another.

    Examples
    --------
    >>> sampler = PathSampler(0, hashed(np.arange(2, dtype=np.uint32)))
    >>> sampler.take(slice(None), 4).shape, sampler.take([1], 1).shape
    ((2, 4), (1, 1))
    """

    index: int
    seeds: Words
    dimension: int = 0

    def take(self, paths: AnyArray | slice | list[int], count: int) -> FloatArray:
        """Return the next numbers of some paths, (n, count) float32 in [0, 1)."""
        seeds, first = self.seeds[paths], self.dimension
        self.dimension += count + count % 2
        if self.dimension <= EVEN_DIMENSIONS:
            columns = [uniforms(self.index, seeds, first + i) for i in range(count)]
        else:
            seeds = hashed(seeds + hashed(np.full(1, self.index, np.uint32)))
            words = [hashed(seeds, first + i) for i in range(count)]
            columns = [(word >> np.uint32(8)) * np.float32(2.0**-24) for word in words]
        return np.asarray(np.stack(columns, axis=1), np.float32)


@dataclass(frozen=True)
class PathTracer:
    """Traces paths through a scene.

    Attributes
    ----------
    context : ShadingContext
    scatterer : Scatterer
    max_bounces : int
        How often light is scattered at most.
    """

    context: ShadingContext
    scatterer: Scatterer
    max_bounces: int

    def light(self, vertices: PathVertices, sampler: PathSampler) -> FloatArray:
        """Return the light that goes from vertices to the eye, (n, 3): of one path each."""
        light = np.zeros((len(vertices), 3), np.float32)
        weight = np.ones_like(light)
        path = np.arange(len(vertices))
        for bounce in range(self.max_bounces):
            if not len(path):
                break
            scattering = self.scatterer.at(vertices)
            light[path] += weight * self._direct(vertices, scattering, sampler, path, bounce)
            # Choose the next direction.
            towards, change = scattering.sample(sampler.take(path, 4))
            weight = weight * np.asarray(change, np.float32)
            lasting = self._roulette(weight, sampler.take(path, 1)[:, 0], bounce)
            path, vertices, towards = path[lasting[0]], vertices.some(lasting[0]), towards[lasting[0]]
            weight = weight[lasting[0]] * lasting[1]
            # Leave the scene, or go on.
            rows, hit = next_vertices(self.context, vertices, towards)
            is_away = np.ones(len(path), bool)
            is_away[rows] = False
            away = np.flatnonzero(is_away)
            light[path[away]] += weight[away] * self.context.rig.sky.radiance(towards[away] @ self.context.up)
            path, weight, vertices = path[rows], weight[rows], hit
        return light

    def _direct(
        self, vertices: PathVertices, scattering: Scattering, sampler: PathSampler, path: AnyArray, bounce: int
    ) -> FloatArray:
        """Return the light of the distant lights: of all of them at first, and of one chosen by chance after a bounce.

        It is chosen by the light that would come if nothing were in between.
        """
        lamps = self.context.rig.lights
        light = np.zeros((len(vertices), 3), np.float32)
        offered = [self._of_lamp(lamp, scattering, sampler.take(path, 2)) for lamp in lamps]
        if bounce == 0 or len(lamps) <= 1:
            for towards, value in offered:
                light += value * unoccluded(self.context, vertices, towards)[:, None]
            return light
        sums = np.cumsum([_sum(value) for _, value in offered], axis=0)
        aim = sampler.take(path, 1)[:, 0] * sums[-1]
        chosen = (aim >= sums[:-1]).sum(axis=0)
        directions = np.choose(chosen[:, None], [towards for towards, _ in offered])
        value = np.choose(chosen[:, None], [value for _, value in offered])
        rows = np.flatnonzero(sums[-1] > 0)
        rows = rows[unoccluded(self.context, vertices.some(rows), directions[rows])]
        share = _sum(value[rows]) / sums[-1][rows]
        light[rows] = value[rows] / share[:, None]
        return light

    def _of_lamp(self, lamp: Light, scattering: Scattering, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return directions to a lamp, one for each vertex, and the light that comes unless something hides it."""
        towards = lamp.sample(self.context.camera, points[:, 0], points[:, 1])
        color = np.asarray(lamp.color, np.float32)
        return towards, np.asarray(scattering.evaluate(towards) * color, np.float32)

    def _roulette(self, weight: FloatArray, chance: FloatArray, bounce: int) -> tuple[AnyArray, AnyArray]:
        """Return which paths go on, and by how much each counts more."""
        lasts = (
            np.ones(len(weight), np.float32) if bounce < SURE_BOUNCES else np.minimum(np.maximum.reduce(weight.T), 1)
        )
        rows = np.flatnonzero(chance < lasts)
        return rows, (1 / lasts[rows])[:, None]


def _sum(light: FloatArray) -> FloatArray:
    """Return the sum of red, green and blue."""
    return np.asarray(light[:, 0] + light[:, 1] + light[:, 2])
