"""Hair: the far field of Chiang et al. (2016), with light that has passed through other hairs.

Light that crosses n hairs on its way is weakened to a_f^n, and by a_f's colour it is tinted. Here a_f is the fraction
that a hair scatters forwards. Light that comes back from the hairs around is spread evenly. This is the dual scattering
of Zinke et al. (2008), with one count of hairs in the place of its two passes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ...support.computed_once import computed_once
from ...support.vectors import across, dot
from ..hair import AveragedHair, HairMaterial
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import SALON, Rig, sphere
from ..shading.shading_context import ShadingContext
from .look import Backdrop
from .variation import shade_of_strands

#: Light from hairs that are farther than this fraction of the size of the scene has passed a head or a body.
FAR = 0.1
#: The fraction of light that misses the hairs around, or that they let pass; figures of Zinke et al., §4.1.
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
        light = np.zeros((len(fragments), 3), np.float32)
        for lamp in context.rig.lights:
            towards = lamp.sample(context.camera, *sampler.next_2d())
            light += np.asarray(lamp.color, np.float32) * self._scattered(fragments, towards, context, is_sharp=True)
        towards = sphere(*sampler.next_2d())
        sky = context.rig.sky.radiance(towards @ context.up) * np.float32(4 * np.pi)
        light += sky * self._scattered(fragments, towards, context, is_sharp=False)
        return light * shade_of_strands(fragments.strand, self.variation)[:, None]

    def _scattered(
        self, fragments: Fragments, towards: FloatArray, context: ShadingContext, is_sharp: bool
    ) -> FloatArray:
        """Return the fraction of the light from a direction that goes to the eye, (n, 3).

        Without sharp lobes, the same light is spread evenly over the half space before and the one behind: enough for
        one direction of a sky, where lobes would be noise.
        """
        hair, tangents = self._averaged, fragments.smooth_tangents
        sin_i, cos_i, across_i = across(tangents, towards)
        sin_o, _, across_o = across(tangents, fragments.to_eye)
        cos_phi = np.clip(dot(across_i, across_o), -1, 1)
        forward, back = hair.forward(sin_i), hair.backward(sin_i)
        before, behind = (((1 + side * cos_phi) * cos_i / np.float32(np.pi**2))[:, None] for side in (1, -1))
        once = hair.evaluate(sin_o, sin_i, np.arccos(cos_phi)) if is_sharp else back * before + forward * behind
        # Weaken and tint the light by the hairs that it crosses.
        passed = forward ** context.count_crossings(fragments.points, towards)[:, None]
        # Stop what has come through the head or the body on which hair grows.
        passed *= context.unoccluded(fragments.points, towards, beyond=FAR * context.size)[:, None]
        # Add what the hairs around scatter back.
        forth = forward**2
        around = back * forth / np.maximum(1 - forth, 0.05) * (1 + back**2 / np.maximum(1 - forth, 0.2) ** 2)
        return np.asarray(passed * (once + DENSITY * around * before), np.float32)
