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
    ab, b2, e2 = dot(a, b), dot(b, b), dot(edge, edge)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Q(s) = c0 + 2·c1·s + c2·s², the squared half chord in the ball at s.
        c0, c1, c2 = radius0**2 - dot(a, a), radius0 * slope - ab, slope**2 - b2
        k = np.sqrt((c1**2 - c0 * c2) / (e2 - slope**2))
        w = e_r * k
        s = np.where(w * c1 > 0, (c1**2 - e_r**2 * c0) / ((e2 - slope**2) * (w + c1)), (w - c1) / c2)
        half_chord = np.sqrt(np.stack([c0 + s * (2 * c1 + s * c2), c0, c0 + 2 * c1 + c2]))
    t = p_r + np.stack([s * e_r, 0 * e_r, e_r]) - half_chord
    on_side = (s >= 0) & (s <= 1) & (e2 > slope**2) & np.isfinite(t[0])
    at_end = np.where(np.isnan(t[1]) | (t[2] < t[1]), 1.0, 0.0)
    found = np.where(on_side, s, at_end)
    depth = np.where(on_side, t[0], np.fmin(t[1], t[2]))
    return (depth + shift) / length, found
