"""Looks that show a number of each ray: how many lines it hits, and how much work that is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import AnyArray, FloatArray, IntArray
from ..camera import Camera
from ..errors import InputError
from ..tree import Tree
from .color.legend import ColorBar
from .looks.look import Backdrop
from .looks.table import NIGHT
from .node_visits import visited_nodes
from .pictures.picture import Picture
from .progressive import Progressive
from .sampling.sobol import points_in_pixels
from .shading.lighting import STUDIO
from .shading.shading_context import ShadingContext

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


class MeasureRenderer(Progressive):
    """Shows a number of the rays of each pixel, sample by sample.

    Parameters
    ----------
    tree, camera, width, height, radius
        As of `Renderer`.
    measure : Measure
    samples : int
        How many rays a pixel has. One goes through its centre. Of several, `Picture.aovs` has the mean.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]]])
    >>> renderer = MeasureRenderer(tree, fl.Camera((0, 0, 5), (0, 0, 0)), 3, 3, 0.2, MEASURES["hits"])
    >>> list(renderer.passes())
    [1]
    >>> renderer.picture().aovs["hits"].tolist()
    [[0.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 0.0]]
    """

    def __init__(
        self, tree: Tree, camera: Camera, width: int, height: int, radius: float, measure: Measure, samples: int = 1
    ) -> None:
        if camera.lens_radius:
            raise InputError(f"{camera!r} has a lens; a measure counts along rays from a pinhole")
        context = ShadingContext.of(tree, camera, height, radius, STUDIO)  # whose lights nothing uses
        super().__init__(context, width, height, samples, {"total": (), "hit": ()})
        self.measure = measure

    def _sample(self, index: int, pixels: AnyArray) -> dict[str, AnyArray]:
        """Return the numbers of one ray of some pixels, and which are not 0."""
        context = self.context
        x, y = points_in_pixels(index if self.samples > 1 else None, pixels, self.width)
        origins, directions, _ = context.camera.ray(x, y, self.width, self.height)
        values = self.measure.count(context.tree, origins, directions, context.radius)
        return {"total": values, "hit": values > 0}

    def picture(self) -> Picture:
        """Return the picture of all samples so far: its `aovs` has the numbers, under the name of the measure."""
        measure, mean, hit = self.measure, self._means("total"), self._means("hit")
        low, high = measure.range or _range(mean[hit > 0])
        # The colour is that of the rays with a number; alpha is their fraction.
        bar, alpha = ColorBar(measure.title, low, high, measure.map), hit.astype(np.float32)
        return Picture(
            bar.colors(mean / np.where(hit > 0, hit, 1)) * alpha[..., None],
            alpha,
            measure.backdrop.light(self.width, self.height),
            self.done,
            is_light=False,
            aovs={measure.name: mean.astype(np.float32)},
            legend=bar,
        )

    @property
    def _shader(self) -> Callable[..., IntArray]:
        return self.measure.count

    def _own_settings(self) -> dict[str, Any]:
        return {"look": self.measure, "rays": "centres of pixels" if self.samples == 1 else "spread over pixels"}


def _range(values: AnyArray) -> tuple[float, float]:
    return 0.0, max(1.0, float(np.quantile(values, BRIGHT))) if len(values) else 1.0
