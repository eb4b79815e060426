"""The renderer of looks that show a number of each ray."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..arrays import AnyArray
from ..errors import InputError
from .color.legend import ColorBar
from .measures import Measure
from .pictures.picture import Picture
from .plan import PicturePlan
from .progressive import Progressive
from .sampling.sobol import points_in_pixels
from .shading.lighting import STUDIO
from .shading.shading_context import ShadingContext

#: The values beyond this quantile have the last colour of the map.
BRIGHT = 0.99


class MeasureRenderer(Progressive):
    """Shows a number of the rays of each pixel, sample by sample.

    Parameters
    ----------
    plan : PicturePlan
        The plan, whose look is a measure. By default a pixel has one ray, through its centre. Of several rays,
        `Picture.aovs` has the mean.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.rendering import MEASURES, PicturePlan
    >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]]])
    >>> renderer = MeasureRenderer(PicturePlan(tree, fl.Camera((0, 0, 5), (0, 0, 0)), 3, 3, 0.2, MEASURES["hits"]))
    >>> list(renderer.passes())
    [1]
    >>> renderer.picture().aovs["hits"].tolist()
    [[0.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 0.0]]
    """

    def __init__(self, plan: PicturePlan) -> None:
        camera = plan.camera
        if camera.lens_radius:
            raise InputError(f"{camera!r} has a lens; a measure counts along rays from a pinhole")
        if not isinstance(plan.look, Measure):
            raise InputError(f"look={plan.look!r}; expected a Measure")
        self.measure = plan.look
        context = ShadingContext.of(plan.tree, camera, plan.height, plan.radius, STUDIO)  # whose lights nothing uses
        super().__init__(context, plan.width, plan.height, plan.options.samples or 1, {"total": (), "hit": ()})

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
            camera=self.context.camera,
            radius=self.context.radius,
            look=measure,
        )

    @property
    def _shader(self) -> Callable[..., AnyArray]:
        return self.measure.count

    def _own_settings(self) -> dict[str, Any]:
        return {"look": self.measure, "rays": "centres of pixels" if self.samples == 1 else "spread over pixels"}


def _range(values: AnyArray) -> tuple[float, float]:
    return 0.0, float(np.quantile(values, BRIGHT)) if len(values) else 1.0
