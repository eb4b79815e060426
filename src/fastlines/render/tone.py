"""From depth to brightness: lighter is nearer, as in the pictures of the thesis (§6).

Half of the brightness falls with the depth itself, half with its rank among the depths that are seen: the second
half spends contrast where the picture has its content, and both together never change which of two depths is lighter.
Samples of a pixel are averaged as light, of which a screen shows the 2.2th root.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..camera import Float64Array

#: The brightness of the furthest line, of 1. The background has 0.
DARKEST = 0.14
#: A screen shows the light v^GAMMA where a picture says v.
GAMMA = 2.2
#: The share of the depths that is drawn as if it were at the nearer (or further) end.
TAIL = 0.01


class Tone:
    """How light a line is at a depth.

    Parameters
    ----------
    depths : array of float
        A fair sample of the depths that will be seen; those that are not finite are ignored.

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
        """The value of a pixel on the screen, 0 to 1; 0 where the depth is inf."""
        return np.where(np.isfinite(depth), np.interp(depth, self._depths, self._brightness), 0.0)

    def light(self, depth: npt.NDArray[np.floating]) -> Float64Array:
        """What a screen then emits, 0 to 1; this can be averaged."""
        return np.asarray(self.brightness(depth) ** GAMMA)


def encode(light: Float64Array) -> npt.NDArray[np.uint8]:
    """Turn light into the bytes of a picture, made lighter if even its lightest lines are dark.

    Lines that cover only a small part of their pixels are dark; the lightest hundredth of all pixels that show any
    becomes white.
    """
    lit = light[light > 0]
    white = min(1.0, float(np.quantile(lit, 0.99))) if len(lit) else 1.0
    shown: npt.NDArray[np.uint8] = (np.minimum(light / white, 1) ** (1 / GAMMA) * 255 + 0.5).astype(np.uint8)
    return shown
