"""Hair in which light is scattered many times, by path tracing with the near field of Chiang et al. (2016)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...arrays import AnyArray, FloatArray
from ..hair import HairMaterial
from ..path_tracing.path_tracer import PathTracer
from ..path_tracing.path_vertices import seen_vertices
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import SALON, Rig
from ..shading.shading_context import ShadingContext
from .look import Backdrop
from .variation import shade_of_strands

#: How often light is scattered at most. Blond hair needs many: a fibre absorbs little.
MAX_BOUNCES = 64


@dataclass(frozen=True)
class TracedHair:
    """Shades hairs by one path for each ray of the camera.

    Attributes
    ----------
    material : HairMaterial
    backdrop : Backdrop
    rig : Rig
    max_bounces : int
        How often light is scattered at most.
    has_ground : bool
        Whether the lines cast a shadow on the ground.
    variation : float
        How much brighter or darker than the mean a hair is, from 0 to 1.
    """

    material: HairMaterial
    backdrop: Backdrop
    rig: Rig = SALON
    max_bounces: int = MAX_BOUNCES
    has_ground: bool = False
    variation: float = 0.0
    is_light: bool = field(default=True, init=False)

    def shade(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the light of each fragment towards the eye, (n, 3) float32 linear."""
        choice, across = sampler.next_2d()
        rows, times = _one_of_each_ray(fragments, choice)
        numbers = Sampler(sampler.index, sampler.seeds[rows], sampler.dimension)
        vertices = seen_vertices(fragments, context, across).some(rows)
        traced = PathTracer(context, self.material, self.max_bounces).light(vertices, numbers)
        light = np.zeros((len(fragments), 3), np.float32)
        light[rows] = traced * (times * shade_of_strands(fragments.strand[rows], self.variation))[:, None]
        return light


def _one_of_each_ray(fragments: Fragments, choice: FloatArray) -> tuple[AnyArray, FloatArray]:
    """Choose a fragment of each ray by its weight, and return by how much it counts more."""
    n_rays = len(fragments.opacity)
    total = np.bincount(fragments.ray, fragments.weight, minlength=n_rays)
    first = np.searchsorted(fragments.ray, np.arange(n_rays))
    after = np.cumsum(fragments.weight, dtype=np.float64)
    before = after - fragments.weight
    start = before[np.minimum(first, len(before) - 1)][fragments.ray]
    aim = start + choice[first[fragments.ray]] * total[fragments.ray]
    rows = np.flatnonzero((before <= aim) & (aim < after))
    return rows, np.asarray(total[fragments.ray[rows]] / fragments.weight[rows], np.float32)
