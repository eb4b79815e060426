"""Hair: the far field of Chiang et al. (2016), with light that has passed through other hairs.

Light that crosses n hairs on average is weakened to exp(−n (1 − a_f)), and by a_f's colour it is tinted. Here a_f is
the fraction that a hair scatters forwards, and a_b the one that it scatters back. That is the mean of a_fᵏ if the count
k is that of independent hairs. The density of lines gives n (`DensityGrid`). This is the dual scattering of Zinke et
al. (2008), with one number of hairs in the place of its two passes.

The hairs around scatter back what a pile of plates does (Stokes 1862), less what one hair does, spread evenly:

    R = a_b + a_f² R / (1 − a_b R)
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ...engines import engine
from ...support.computed_once import computed_once
from ..hair import AveragedHair, HairMaterial
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import SALON, Rig
from ..shading.shading_context import ShadingContext
from .look import Backdrop
from .variation import shade_of_strands

#: Light from hairs that are farther than this fraction of the size of the scene has passed a head or a body.
FAR = 0.1
#: The fraction of what the hairs around scatter back that arrives (Zinke et al., §4.1).
DENSITY = 0.7


@dataclass(frozen=True)
class Hair:
    """Shades hairs that are thinner than a pixel.

    Attributes
    ----------
    material : HairMaterial
    backdrop : Backdrop
    rig : Rig
    has_ground : bool
        Whether the lines cast a shadow on the ground.
    variation : float
        How much brighter or darker than the mean a hair is, from 0 to 1.
    """

    material: HairMaterial
    backdrop: Backdrop
    rig: Rig = SALON
    is_light: bool = field(default=True, init=False)
    has_ground: bool = False
    variation: float = 0.0

    @computed_once
    def _averaged(self) -> AveragedHair:
        return AveragedHair(self.material)

    def shade(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the light of each fragment towards the eye, (n, 3) float32 linear."""
        lamps = context.lamps
        numbers = sampler.index, sampler.seeds, sampler.dimension
        to_lamps, to_sky, radiance, jitter = engine.light_samples(lamps, context.sky, numbers)
        sampler.dimension += 2 * len(lamps) + 6
        light = self._scattered(fragments, context, jitter, to_sky, np.float32(4 * np.pi) * radiance, is_sharp=False)
        for towards, lamp in zip(to_lamps.reshape(len(lamps), len(fragments), 3), lamps, strict=True):
            light += self._scattered(fragments, context, jitter, towards, lamp[9:], is_sharp=True)
        return light * shade_of_strands(fragments.strand, self.variation)[:, None]

    def _scattered(
        self,
        fragments: Fragments,
        context: ShadingContext,
        jitter: FloatArray,
        towards: FloatArray,
        color: FloatArray,
        is_sharp: bool,
    ) -> FloatArray:
        """Return the light from a direction of some irradiance that goes to the eye, (n, 3).

        Without sharp lobes, the same light is spread evenly over the half space before and the one behind: enough for
        one direction of a sky, where lobes would be noise.
        """
        tangents = fragments.smooth_tangents
        crossed = context.optical_depth(fragments.points, tangents, towards, jitter, FAR * context.size)
        hair = self._averaged
        light = towards, color, *crossed
        arrays = (hair.material.numbers, *hair.tables), (tangents, fragments.to_eye), light
        return engine.light_of_hair(*arrays, is_sharp, DENSITY)
