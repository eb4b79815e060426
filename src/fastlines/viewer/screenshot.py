"""Screenshots: what a browser shows of the scene, with the legend, as a PNG."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import numpy as np

from ..rendering.color.legend import draw_legend
from .line_colors import LineLegend

#: The longest side of a screenshot in pixels, and how long a browser may take for it, in seconds.
LONGEST, PATIENCE = 2048, 60.0
#: The colour behind the scene.
BACKGROUND = (20, 20, 20)


def screenshot(client: Any, legend: LineLegend | None = None) -> bytes:
    """Return what a browser shows, by its own camera, as a PNG; a colour bar is drawn into a corner.

    Raises
    ------
    RuntimeError, TimeoutError
        If the browser goes away, or takes too long.
    """
    from PIL import Image

    camera = client.camera
    shrink = min(1.0, LONGEST / max(camera.image_width, camera.image_height, 1))
    size = round(camera.image_height * shrink), round(camera.image_width * shrink)
    pixels = client.get_render(*size, transport_format="png", timeout=PATIENCE)
    image = Image.new("RGBA", pixels.shape[1::-1], (*BACKGROUND, 255))
    image.alpha_composite(Image.fromarray(pixels))
    shown = np.asarray(image.convert("RGB"))
    if legend is not None and legend.bar is not None:
        shown = draw_legend(shown, replace(legend.bar, title=legend.title.partition(":")[0]))
    stream = io.BytesIO()
    Image.fromarray(shown).save(stream, "PNG")
    return stream.getvalue()
