"""Solid lines: fibres and tubes, in the colours of their directions, strands or attributes.

Surfaces scatter light evenly, and have a highlight; `surface_material` has the formula. Lines thinner than a pixel
scatter it evenly around their axis, as cylinders do: of the light that meets them, the fraction (1 + cos φ)·cos θ / π²
goes in each direction.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...arrays import FloatArray
from ...engines import engine
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import STUDIO, Rig
from ..shading.shading_context import ShadingContext
from .color import Color
from .look import Backdrop
from .surface_material import SATIN, SurfaceMaterial

#: Occlusion counts up to this fraction of the size of the scene.
NEAR = 0.06
#: How many random numbers a fragment takes.
N_NUMBERS = 10
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
        Its highlight. That of thin lines is (1 − (t · h)²)^(exponent/2) times what they scatter evenly, where t is the
        direction of the line.
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
        material = self.material
        base = np.ascontiguousarray(self.color.of(fragments, context), np.float32)
        thin = fragments.normals is None
        axes = fragments.smooth_tangents if fragments.normals is None else fragments.normals
        constants = 1 - material.metallic, material.exponent, *material.shine
        numbers = sampler.index, sampler.seeds, sampler.dimension
        lit, ambient, jitter = engine.light_of_solids(
            (axes, fragments.to_eye), base, thin, constants, context.lamps, context.sky, numbers
        )
        sampler.dimension += N_NUMBERS
        near = NEAR * context.size
        light = _arriving(fragments, context, jitter, *lit) + _arriving(fragments, context, jitter, *ambient, near)
        return self._hazed(light, fragments, context)

    def _hazed(self, light: FloatArray, fragments: Fragments, context: ShadingContext) -> FloatArray:
        if not self.haze:
            return light
        box = context.tree.box.astype(np.float64)
        middle = float(np.sqrt(((box.mean(axis=0) - context.camera.origin) ** 2).sum()))
        place = np.clip((fragments.hits.t - middle) / max(context.size, 1e-30) + 0.5, 0, 1)
        fade = np.asarray(self.haze * place, np.float32)[:, None]
        behind = self.backdrop.light(1, 1)[0]
        return np.asarray(light + fade * (behind - light), np.float32)


def _arriving(
    fragments: Fragments,
    context: ShadingContext,
    jitter: FloatArray,
    towards: FloatArray,
    light: FloatArray,
    distance: float = np.inf,
) -> FloatArray:
    """Return the light from some directions that nothing hides up to a distance; thin lines hide a part of it."""
    if fragments.normals is None and context.density is not None:
        places = fragments.points, fragments.smooth_tangents
        crossed, _ = context.density.optical_depth(*places, towards, jitter, distance, distance)
        return engine.attenuated(light, crossed)
    rows = np.flatnonzero(light.any(axis=1))
    rows = rows[context.unoccluded(fragments.points[rows], towards[rows], distance)]
    arriving = np.zeros_like(light)
    arriving[rows] = light[rows]
    return arriving
