"""The grey of depths: lighter is nearer, as in the pictures of the thesis (§6).

Half of the brightness falls with the depth itself. The other half falls with the rank among the visible depths, which
gives contrast to the depths that occur most. Samples of a pixel are averaged as linear light.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray
from ...camera import Camera, Float64Array
from ...geometry.any_geometry import AnyGeometry
from ..color.tone import linear, srgb, to_bytes
from ..pictures.picture import Picture
from .depth import View

#: Lines of a smaller radius, in pixels, are drawn by the fraction of a pixel that they cover.
THIN = 0.3
#: The radius in pixels of the spot around a ray in which thin lines are gathered for the range of depths.
SPOT = 1.0
#: Pixels a side of the small picture that finds the range of depths.
PROBE = 192
#: The brightness of the farthest line, as a fraction of the greatest. The background has 0.
DARKEST = 0.14
#: A screen emits the light v^GAMMA for the pixel value v.
GAMMA = 2.2
#: The fraction of the depths beyond each end of the range; they are drawn as if at that end.
TAIL = 0.01


def pixel_size(geometry: AnyGeometry, camera: Camera, height: int) -> float:
    """Return the side of a pixel at the distance of the middle of a geometry, in its units."""
    if len(geometry) == 0:
        return 0.0
    middle = geometry.bounds.astype(np.float64).mean(axis=0) + geometry.offset
    distance = float(np.sqrt(((middle - camera.origin) ** 2).sum()))
    return 2 * math.tan(math.radians(camera.fov_degrees) / 2) / height * distance


def probe(view: View, radius: float) -> FloatArray:
    """Return the depths of a small version of the picture, or of the ends of all lines if it hits too few."""
    shrink = max(1.0, max(view.width, view.height) / PROBE)
    small = replace(view, width=max(1, round(view.width / shrink)), height=max(1, round(view.height / shrink)))
    depth = small.depth(radius, slice(0, small.height))
    if np.isfinite(depth).sum() < 64:
        offsets = view.tree.geometry.span()[0].astype(np.float64) - view.camera.origin
        depth = np.sqrt((offsets**2).sum(axis=1)).astype(np.float32)
    return depth


class Tone:
    """The brightness of a line at a depth, by a fair sample of the visible depths; of two the nearer one is lighter.

    Examples
    --------
    >>> tone = Tone([1.0, 2.0, 3.0])
    >>> tone.brightness(np.array([1.0, 3.0, np.inf])).round(3).tolist()
    [1.0, 0.14, 0.0]
    """

    def __init__(self, depths: npt.ArrayLike) -> None:
        visible = np.asarray(depths, np.float64).ravel()
        visible = np.sort(visible[np.isfinite(visible)])
        if len(visible) == 0:
            visible = np.zeros(1)
        near, far = np.quantile(visible, [TAIL, 1 - TAIL])
        self._depths = np.linspace(near, far, 256)
        rank = np.searchsorted(visible, self._depths, "right") / len(visible)
        rank = (rank - rank[0]) / max(rank[-1] - rank[0], 1e-9)
        fall = 0.5 * np.linspace(0, 1, 256) + 0.5 * rank
        self._brightness = 1 - (1 - DARKEST) * (fall if far > near else np.zeros(256))

    def brightness(self, depth: npt.NDArray[np.floating]) -> Float64Array:
        """Return the value of a pixel, 0 to 1; 0 where the depth is inf."""
        return np.where(np.isfinite(depth), np.interp(depth, self._depths, self._brightness), 0.0)

    def light(self, depth: npt.NDArray[np.floating]) -> Float64Array:
        """Return the light that a screen emits, 0 to 1, which can be averaged."""
        return np.asarray(self.brightness(depth) ** GAMMA)


def grey(picture: Picture) -> npt.NDArray[np.uint8]:
    """Return a picture of the look "depth" as (height, width) uint8, lighter than it is.

    Lines that cover only a small part of their pixels are dark. So the picture is made lighter, until the lightest
    hundredth of its lit pixels is white.
    """
    light = linear(picture.to_bytes()[..., 0] / 255)
    lit = light[light > 0]
    white = float(np.quantile(lit, 0.99)) if len(lit) else 1.0
    return to_bytes(srgb(light / white))
