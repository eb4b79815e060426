"""Looks that show a number of each ray: how many lines it hits, and how much work that is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..arrays import AnyArray, FloatArray, IntArray
from ..camera import Camera
from ..progress import ProgressOption, reporting
from ..tree import Tree
from .depth import MAX_RAYS, bands, check_size
from .legend import ColorBar
from .looks.look import Backdrop
from .looks.table import NIGHT
from .palette import mapped
from .picture import Picture
from .sampling import points_in_pixels
from .work import visited_nodes

#: The values beyond this quantile have the last colour of the map.
BRIGHT = 0.99


@dataclass(frozen=True)
class Measure:
    """A number of each ray, shown by a colour map.

    Attributes
    ----------
    name : str
        Its key in `Picture.aovs`.
    title : str
        What the legend says.
    count : callable
        Takes a tree, the origins and the directions of rays, and the radius; returns a number for each ray, (n,).
    map : str
        The colour map.
    range : pair of floats, optional
        The numbers at both ends of the map; by default 0 and the 99 % quantile of the pixels that are not 0.
    backdrop : Backdrop
        What is behind pixels of 0.
    """

    name: str
    title: str
    count: Callable[[Tree, FloatArray, FloatArray, float], IntArray]
    map: str
    range: tuple[float, float] | None = None
    backdrop: Backdrop = NIGHT


def _hits(tree: Tree, origins: FloatArray, directions: FloatArray, radius: float) -> IntArray:
    return tree.count_hits(origins, directions, radius)


#: The measures by name.
MEASURES = {
    "hits": Measure("hits", "hits per ray", _hits, "viridis"),
    "work": Measure("work", "nodes visited per ray", visited_nodes, "inferno"),
}


def measured_picture(
    tree: Tree,
    camera: Camera,
    width: int,
    height: int,
    radius: float,
    measure: Measure,
    samples: int = 1,
    progress: ProgressOption = False,
) -> Picture:
    """Show a number of the rays of each pixel.

    Parameters
    ----------
    tree, camera, width, height, radius, progress
        As in `render`.
    measure : Measure
    samples : int
        How many rays a pixel has. One goes through its centre. Of several, `Picture.aovs` has the mean.

    Returns
    -------
    Picture
        Its `aovs` has the numbers, (height, width) float32, under the name of the measure.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]]])
    >>> picture = measured_picture(tree, fl.Camera((0, 0, 5), (0, 0, 0)), 3, 3, 0.2, MEASURES["hits"])
    >>> picture.aovs["hits"].tolist()
    [[0.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 0.0]]
    """
    check_size(width, height)
    total, hit = np.zeros(height * width), np.zeros(height * width)
    with reporting(progress, "render") as callback:
        for index in range(samples):
            for rows in bands(width, height, MAX_RAYS):
                own = slice(rows.start * width, rows.stop * width)
                pixels = np.arange(own.start, own.stop)
                x, y = points_in_pixels(index if samples > 1 else None, pixels, width)
                origins, directions, _ = camera.ray(x, y, width, height)
                values = measure.count(tree, origins, directions, radius)
                total[own] += values
                hit[own] += values > 0
                if callback is not None:
                    callback((index + rows.stop / height) / samples)
    low, high = measure.range or _range(total[hit > 0] / samples)
    # The colour is that of the rays with a number; alpha is their fraction.
    place = (total / np.maximum(hit, 1) - low) / max(high - low, 1e-30)
    alpha = (hit / samples).astype(np.float32)
    light = (mapped(place, measure.map) * alpha[:, None]).reshape(height, width, 3)
    aovs = {measure.name: (total / samples).astype(np.float32).reshape(height, width)}
    backdrop = measure.backdrop.light(width, height)
    legend = ColorBar(measure.title, low, high, measure.map)
    return Picture(light, alpha.reshape(height, width), backdrop, samples, is_light=False, aovs=aovs, legend=legend)


def _range(values: AnyArray) -> tuple[float, float]:
    return 0.0, max(1.0, float(np.quantile(values, BRIGHT))) if len(values) else 1.0
