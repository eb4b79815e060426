"""Solid lines: fibres and tubes, in the colours of their directions, strands or attributes.

Surfaces scatter light evenly, and have a highlight. Lines thinner than a pixel scatter it evenly around their axis, as
cylinders do: of the light that meets them, the fraction (1 + cos φ)·cos θ / π² goes in each direction.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...arrays import AnyArray, FloatArray
from ...support.vectors import across, dot, unit
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import STUDIO, Rig, hemisphere, sphere
from ..shading.shading_context import ShadingContext
from .color import Color
from .look import Backdrop

#: Occlusion counts up to this fraction of the size of the scene.
NEAR = 0.06
#: The exponent and the strength of the highlight.
SHARP, GLOSS = 40.0, 0.12


@dataclass(frozen=True)
class Solid:
    """Shades surfaces, or lines thinner than a pixel.

    Attributes
    ----------
    color : Color
        What gives lines their colour.
    backdrop : Backdrop
    rig : Rig
    haze : float
        How much the farthest lines fade into the backdrop, from 0 to 1.
    gloss : float
        The strength of the highlight.
    has_ground : bool
        Whether the lines cast a shadow on the ground.
    """

    color: Color
    backdrop: Backdrop
    rig: Rig = STUDIO
    haze: float = 0.0
    gloss: float = GLOSS
    has_ground: bool = False
    is_light: bool = field(default=True, init=False)

    def shade(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the light of each fragment towards the eye, (n, 3) float32 linear."""
        base = self.color.of(fragments, context)
        light = np.zeros((len(fragments), 3), np.float32)
        for lamp in context.rig.lights:
            towards = lamp.sample(context.camera, *sampler.next_2d())
            diffuse, shine = self._reflected(fragments, towards)
            lit = np.flatnonzero(diffuse + shine > 0)
            lit = lit[context.unoccluded(fragments.points[lit], towards[lit])]
            color = np.asarray(lamp.color, np.float32)
            light[lit] += color * (base[lit] * diffuse[lit, None] + self.gloss * shine[lit, None])
        light += base * self._ambient(fragments, context, sampler)
        return self._hazed(light, fragments, context)

    def _reflected(self, fragments: Fragments, towards: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return the parts of a distant light that are scattered evenly, and that are in the highlight."""
        half = unit(towards + fragments.to_eye)
        if fragments.normals is not None:
            facing = dot(fragments.normals, towards)
            shine = np.maximum(dot(fragments.normals, half), 0) ** SHARP * (facing > 0)
            return np.maximum(facing, 0) / np.float32(np.pi), shine
        even = _cylinder(fragments, towards)
        shine = np.maximum(1 - dot(fragments.tangents, half) ** 2, 0) ** (SHARP / 2) * even
        return even, shine

    def _ambient(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the light of the sky that arrives and is scattered evenly, by one ray."""
        if fragments.normals is not None:
            towards = hemisphere(fragments.normals, *sampler.next_2d())
            share = np.ones(len(fragments), np.float32)
        else:
            towards = sphere(*sampler.next_2d())
            share = _cylinder(fragments, towards) * np.float32(4 * np.pi)
        unoccluded = context.unoccluded(fragments.points, towards, NEAR * context.size)
        return context.rig.sky.radiance(towards @ context.up) * (share * unoccluded)[:, None]

    def _hazed(self, light: FloatArray, fragments: Fragments, context: ShadingContext) -> FloatArray:
        if not self.haze:
            return light
        box = context.tree.box.astype(np.float64)
        middle = float(np.sqrt(((box.mean(axis=0) - context.camera.origin) ** 2).sum()))
        place = np.clip((fragments.hits.t - middle) / max(context.size, 1e-30) + 0.5, 0, 1)
        fade = np.asarray(self.haze * place, np.float32)[:, None]
        behind = self.backdrop.light(1, 1)[0]
        return np.asarray(light + fade * (behind - light), np.float32)


def _cylinder(fragments: Fragments, towards: FloatArray) -> AnyArray:
    """Return the fraction of the light from a direction that thin lines scatter to the eye, per steradian."""
    _, cos_i, across_i = across(fragments.tangents, towards)
    _, _, across_o = across(fragments.tangents, fragments.to_eye)
    return np.asarray((1 + dot(across_i, across_o)) * cos_i / np.float32(np.pi**2))
