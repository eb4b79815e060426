"""Solid lines: fibres and tubes, in the colours of their directions, strands or attributes.

Surfaces scatter light evenly, and have a highlight; `surface_material` has the formula. Lines thinner than a pixel
scatter it evenly around their axis, as cylinders do: of the light that meets them, the fraction (1 + cos φ)·cos θ / π²
goes in each direction.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...arrays import AnyArray, FloatArray
from ...support.vectors import across, dot, unit
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import STUDIO, Rig, hemisphere, sphere
from ..shading.shading_context import ShadingContext
from .color import Color
from .look import Backdrop
from .surface_material import SATIN, SurfaceMaterial

#: Occlusion counts up to this fraction of the size of the scene.
NEAR = 0.06
#: How much the farthest lines fade at most before a backdrop that is lighter than this.
SLIGHT_HAZE, LIGHT = 0.15, 0.2


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
    material : SurfaceMaterial
        How rough the lines are, and whether they are metal.
    has_ground : bool
        Whether the lines cast a shadow on the ground.
    """

    color: Color
    backdrop: Backdrop
    rig: Rig = STUDIO
    haze: float = 0.0
    material: SurfaceMaterial = SATIN
    has_ground: bool = False
    is_light: bool = field(default=True, init=False)

    def before(self, backdrop: Backdrop) -> Solid:
        """Return the look before another backdrop; haze that is light must be slight, or colours are washed out."""
        is_light = float(backdrop.light(1, 1).mean()) > LIGHT
        return replace(self, backdrop=backdrop, haze=min(self.haze, SLIGHT_HAZE) if is_light else self.haze)

    def shade(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the light of each fragment towards the eye, (n, 3) float32 linear."""
        base = self.color.of(fragments, context)
        matt, (white, tinted) = base * np.float32(1 - self.material.metallic), self.material.shine
        glint = np.float32(white) + np.float32(tinted) * base
        light = np.zeros((len(fragments), 3), np.float32)
        for lamp in context.rig.lights:
            towards = lamp.sample(context.camera, *sampler.next_2d())
            diffuse, shine = self._reflected(fragments, towards)
            lit = np.flatnonzero(diffuse + shine > 0)
            lit = lit[context.unoccluded(fragments.points[lit], towards[lit])]
            color = np.asarray(lamp.color, np.float32)
            light[lit] += color * (matt[lit] * diffuse[lit, None] + glint[lit] * shine[lit, None])
        light += base * self._ambient(fragments, context, sampler)
        return self._hazed(light, fragments, context)

    def _reflected(self, fragments: Fragments, towards: FloatArray) -> tuple[AnyArray, AnyArray]:
        """Return the parts of a distant light that are scattered evenly, and that are in the highlight."""
        sharp = self.material.exponent
        half = unit(towards + fragments.to_eye)
        if fragments.normals is not None:
            facing = dot(fragments.normals, towards)
            shine = np.maximum(dot(fragments.normals, half), 0) ** sharp * (facing > 0)
            return np.maximum(facing, 0) / np.float32(np.pi), shine
        even = _cylinder(fragments, towards)
        shine = np.maximum(1 - dot(fragments.tangents, half) ** 2, 0) ** (sharp / 2) * even
        return even, shine

    def _ambient(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the light of the sky that arrives, by one ray: scattered evenly, or mirrored by a metal."""
        if fragments.normals is not None:
            metallic = np.float32(self.material.metallic)
            first, second = sampler.next_2d()
            is_mirror = first < metallic
            rescaled = (first - metallic) / np.maximum(1 - metallic, np.float32(1e-6))
            normals, to_eye = fragments.normals, fragments.to_eye
            towards = hemisphere(normals, np.where(is_mirror, first, rescaled), second)
            mirrored = 2 * dot(normals, to_eye)[:, None] * normals - to_eye
            towards = np.where(is_mirror[:, None], mirrored, towards)
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
