"""Brightness by depth: lighter is nearer, as in the pictures of the thesis (§6).

Half of the brightness falls with the depth itself, and half with its rank among the visible depths. The second half
spends contrast where the picture has its content. Of two depths the nearer one is always lighter. Samples of a pixel
are averaged as light, whose 2.2th root a picture stores.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..camera import Float64Array

#: The brightness of the farthest line, as a fraction of the greatest. The background has 0.
DARKEST = 0.14
#: A screen emits the light v^GAMMA for the pixel value v.
GAMMA = 2.2
#: The fraction of the depths beyond each end of the range; they are drawn as if at that end.
TAIL = 0.01


class Tone:
    """The brightness of a line at a depth.

    Parameters
    ----------
    depths : array of float
        A fair sample of the visible depths; those that are not finite are ignored.

    Examples
    --------
    >>> tone = Tone([1.0, 2.0, 3.0])
    >>> tone.brightness(np.array([1.0, 3.0, np.inf])).round(3).tolist()
    [1.0, 0.14, 0.0]
    """

    def __init__(self, depths: npt.ArrayLike) -> None:
        seen = np.asarray(depths, np.float64).ravel()
        seen = np.sort(seen[np.isfinite(seen)])
        if len(seen) == 0:
            seen = np.zeros(1)
        near, far = np.quantile(seen, [TAIL, 1 - TAIL])
        self._depths = np.linspace(near, far, 256)
        rank = np.searchsorted(seen, self._depths, "right") / len(seen)
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
    shown: npt.NDArray[np.uint8] = (np.minimum(light / white, 1) ** (1 / GAMMA) * 255 + 0.5).astype(np.uint8)
    return shown
