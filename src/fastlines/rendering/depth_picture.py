"""The depth picture: several samples a pixel, or the coverage of a pixel by lines much thinner than it.

A line of radius r covers the fraction 2r·k(x) of a small spot around a ray. Here x is its distance from the ray, and k
the kernel of Epanechnikov across the line, 3/(4R)·(1 − x²/R²), with the radius R of the spot. From the nearest on, each
hit within R of the ray hides this fraction of the lines behind it. So one query for all hits gives the picture to which
very many samples would converge.

Lighter is nearer, as in the pictures of the thesis (§6). Half of the brightness falls with the depth itself. The other
half falls with the rank among the visible depths, which gives contrast to the depths that occur most. Samples of a
pixel are averaged as linear light, which the picture stores with a gamma of 2.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray
from ..camera import Camera, Float64Array
from ..curves import Curves
from ..geometry import AnyGeometry, points_of, radius_beyond
from ..lines import Lines
from ..progress import ProgressOption, reporting
from ..tree import Tree
from .depth import View, bands, check_radius, check_size

#: The fraction of a picture that is done, some of its rows, and the light to add to them.
Part: TypeAlias = tuple[float, slice, Float64Array]

#: Lines of a smaller radius, in pixels, are drawn by the fraction of a pixel that they cover.
THIN = 0.3
#: The radius in pixels of the spot around a ray in which thin lines are gathered.
SPOT = 1.0
#: About how many hits are listed at a time.
MAX_HITS = 1 << 22
#: Pixels a side of the small picture that finds the range of depths.
PROBE = 192
#: The brightness of the farthest line, as a fraction of the greatest. The background has 0.
DARKEST = 0.14
#: A screen emits the light v^GAMMA for the pixel value v.
GAMMA = 2.2
#: The fraction of the depths beyond each end of the range; they are drawn as if at that end.
TAIL = 0.01


def depth_picture(
    tree: Tree,
    camera: Camera,
    width: int,
    height: int,
    radius: float | None = None,
    samples: int = 3,
    progress: ProgressOption = False,
) -> npt.NDArray[np.uint8]:
    """Draw the lines, lighter where they are nearer, on black.

    Parameters
    ----------
    tree, camera, width, height, radius, progress
        As in `depth_image`.
    samples : int
        Average this many by this many samples a pixel, 1 to 16.

    Returns
    -------
    (height, width) uint8

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 1, 0], [1, 1, 0]], [[-1, -1, -3], [1, -1, -3]]])
    >>> picture = depth_picture(tree, fl.Camera(origin=(0, 0, 8), target=(0, 0, 0)), 80, 80, radius=0.1)
    >>> int(picture[:40].max()) > int(picture[40:].max()) > int(picture[40, 40])
    True
    """
    check_size(width, height)
    radius = check_radius(tree, radius)
    view = View(tree, camera, width, height)
    geometry = tree.geometry
    pixel = pixel_size(geometry, camera, height)
    thin = isinstance(geometry, Lines | Curves) and radius + geometry.max_radius < THIN * pixel
    reach = SPOT * pixel if thin else radius
    tone = Tone(probe(view, reach))
    light = np.zeros((height, width))
    with reporting(progress, "render") as callback:
        parts = _gather(view, radius, reach, tone) if thin else _sample(view, radius, samples, tone)
        for done, rows, more in parts:
            light[rows] += more
            if callback is not None:
                callback(done)
    return encode(light if thin else light / samples**2)


def pixel_size(geometry: AnyGeometry, camera: Camera, height: int) -> float:
    """Return the side of a pixel at the distance of the middle of a geometry, in its units."""
    if len(geometry) == 0:
        return 0.0
    middle = geometry.bounds.astype(np.float64).mean(axis=0)
    distance = float(np.sqrt(((middle - camera.origin) ** 2).sum()))
    return 2 * math.tan(math.radians(camera.fov_degrees) / 2) / height * distance


def probe(view: View, radius: float) -> FloatArray:
    """Return the depths of a small version of the picture, or of the ends of all lines if it hits too few."""
    shrink = max(1.0, max(view.width, view.height) / PROBE)
    small = replace(view, width=max(1, round(view.width / shrink)), height=max(1, round(view.height / shrink)))
    depth = small.depth(radius, slice(0, small.height))
    if np.isfinite(depth).sum() < 64:
        offsets = points_of(view.tree.geometry)[0].astype(np.float64) - view.camera.origin
        depth = np.sqrt((offsets**2).sum(axis=1)).astype(np.float32)
    return depth


def _sample(view: View, radius: float, samples: int, tone: Tone) -> Iterator[Part]:
    """Add up the light of a grid of samples in each pixel."""
    offsets = [((i + 0.5) / samples, (j + 0.5) / samples) for j in range(samples) for i in range(samples)]
    for n_done, at in enumerate(offsets):
        for rows in bands(view.width, view.height):
            done = (n_done + rows.stop / view.height) / len(offsets)
            yield done, rows, tone.light(view.depth(radius, rows, at))


def _gather(view: View, radius: float, reach: float, tone: Tone) -> Iterator[Part]:
    """Add up the light of all lines near each ray, weighted by the fraction of the spot that each covers."""
    counts = view.tree.count_hits(*replace(view, width=32, height=32).rays(slice(0, 32)), reach)
    max_rays = int(MAX_HITS / max(4.0, counts.mean()))
    for rows in bands(view.width, view.height, max_rays):
        hits = view.tree.all_hits(*view.rays(rows), reach)
        own = hits.sample("radius") if radius_beyond(view.tree.geometry) > 0 else 0.0
        spot = reach + own
        share = 2 * (radius + own) * 0.75 / spot * (1 - (hits.distance.astype(np.float64) / spot) ** 2)
        hidden = np.cumsum(np.log1p(-np.clip(share, 0, 0.999)))
        before = np.concatenate([[0.0], hidden])
        left_over = np.exp(before[:-1] - before[hits.offsets[hits.ray]])
        weights = share * left_over * tone.light(hits.t)
        light = np.bincount(hits.ray, weights, minlength=len(hits.offsets) - 1)
        yield rows.stop / view.height, rows, np.asarray(light, np.float64).reshape(-1, view.width)


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


def encode(light: Float64Array) -> npt.NDArray[np.uint8]:
    """Turn light into the bytes of a picture.

    Lines that cover only a small part of their pixels are dark. So the picture is made lighter, until the lightest
    hundredth of its lit pixels is white.
    """
    lit = light[light > 0]
    white = min(1.0, float(np.quantile(lit, 0.99))) if len(lit) else 1.0
    return np.asarray(np.minimum(light / white, 1) ** (1 / GAMMA) * 255 + 0.5).astype(np.uint8)
