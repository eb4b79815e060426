"""Where lines enter round cones, in float64.

The formulas are those of cpp/fastlines/primitives/round_cone_test.hpp.
"""

from __future__ import annotations

import numpy as np

from ..support.vectors import dot
from .hit_places import Float64Array


def enter_round_cones(
    start: Float64Array,
    edge: Float64Array,
    radius0: Float64Array,
    slope: Float64Array,
    origins: Float64Array,
    directions: Float64Array,
) -> tuple[Float64Array, Float64Array]:
    """Find where lines enter round cones, which they hit, one ray and one round cone a row.

    Parameters
    ----------
    start, edge : (n, 3)
        The start of the axis, and its end − start.
    radius0, slope : (n,)
        The radius at the start, and how much larger it is at the end.
    origins, directions : (n, 3)

    Returns
    -------
    t, s : (n,)
        In units of the direction's length; and the place on the axis of the ball that the line touches there. NaN if
        rounding makes the line miss.

    Examples
    --------
    >>> start, edge = np.array([[0.0, 0, 0]]), np.array([[4.0, 0, 0]])
    >>> origins, directions = np.array([[2.0, 0, -5]]), np.array([[0.0, 0, 2]])
    >>> t, s = enter_round_cones(start, edge, np.ones(1), np.zeros(1), origins, directions)
    >>> print(t, s)
    [2.] [0.5]
    """
    length = np.sqrt(dot(directions, directions))
    ray = directions / length[:, None]
    # Measure depths from the point of the line that is nearest to the middle of the axis, so that nothing cancels.
    shift = dot(start + 0.5 * edge - origins, ray)
    offset = start - origins - shift[:, None] * ray
    p_r, e_r = dot(offset, ray), dot(edge, ray)
    a, b = offset - p_r[:, None] * ray, edge - e_r[:, None] * ray
    b2, m2 = dot(b, b), slope**2
    c2 = m2 - b2
    length2 = e_r**2 - c2
    is_steep = c2 >= 0
    larger_end, smaller_end = np.where(slope > 0, 1.0, 0.0), np.where(slope > 0, 0.0, 1.0)

    def ball(s: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array, Float64Array]:
        """Return the centre of the ball at s across the ray, its radius, Q(s), and half the derivative of Q there."""
        x, reach = a + s[:, None] * b, radius0 + s * slope
        return x, reach, reach**2 - dot(x, x), reach * slope - dot(x, b)

    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # The line hits if the largest Q, the squared half chord in the ball at s, is 0 or more.
        inmost = np.where(is_steep, larger_end, np.clip((dot(a, b) - radius0 * slope) / c2, 0, 1))
        _, _, c0, c1 = ball(inmost)
        hits, flat = c0 >= 0, c1**2 - c0 * c2
        # Expand Q where the radius is least, and find the ball that the line touches.
        expanded_at = np.where(b2 < 2 * m2, smaller_end, inmost)
        x, reach, c0, c1 = ball(expanded_at)
        g = slope[:, None] * x - reach[:, None] * b
        steep = dot(g, g) - dot(np.cross(x, b), ray) ** 2
        w = e_r * np.sqrt(np.maximum(np.where(is_steep, steep, flat), 0) / length2)
        step = np.where(w * c1 > 0, (c1**2 - e_r**2 * c0) / (length2 * (w + c1)), (w - c1) / c2)
        end = np.where(slope == 0, np.where(e_r < 0, 1.0, 0.0), larger_end)
        at_end = is_steep & ((e_r * slope <= 0) | (length2 <= 0))
        s = np.where(at_end, end, np.clip(np.nan_to_num(expanded_at + step), 0, 1))
        depth = np.where(hits, p_r + s * e_r - np.sqrt(np.maximum(ball(s)[2], 0)), np.nan)
    return (depth + shift) / length, s
