"""Pictures of small trees: the boxes of each level over the primitives, as SVG (thesis, figures 1.1 and 1.2)."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable, Sequence
from html import escape
from typing import TypeAlias, TypeVar

from ..support.texts import counted
from .primitive import Box, Point, Primitive, Prims, Segment

T = TypeVar("T")
Pixel: TypeAlias = tuple[float, float]
#: The boxes of a level, and whether each is that of a leaf.
Level: TypeAlias = Sequence[tuple[Box, bool]]

#: The most levels, boxes in a level and primitives that are drawn; of more, some that are spaced evenly.
MAX_LEVELS, MAX_BOXES, MAX_PRIMS = 6, 64, 160
#: The size of a panel in pixels, the space around it, its caption, and how many stand side by side.
SIDE, GAP, CAPTION, COLUMNS = 180, 12, 18, 3


def levels_svg(title: str, prims: Prims, levels: Sequence[Level]) -> str | None:
    """Draw the levels of a tree, projected along the axis on which its box is shortest.

    Parameters
    ----------
    title : str
        What a screen reader says.
    prims : sequence of Primitive
        Segments are drawn as such, others as their boxes.
    levels : sequence of sequence of (Box, bool)
        The boxes of each level from the root on, and whether each is that of a leaf.

    Returns
    -------
    str or None
        None if the root's box is not finite, so that there is no scale.
    """
    root = levels[0][0][0]
    sides = root.sides()
    if not all(map(math.isfinite, sides)):
        return None
    short = 2 - sides[::-1].index(min(sides))
    across, upwards = (axis for axis in range(3) if axis != short)
    longest = max(sides[across], sides[upwards])
    scale = SIDE / longest if longest > 0 else 0.0
    height = max(24.0, sides[upwards] * scale)

    def at(point: Point) -> Pixel:
        return (point[across] - root.lo[across]) * scale, (root.hi[upwards] - point[upwards]) * scale

    drawn, panels = levels[:MAX_LEVELS], list[str]()
    strokes = "".join(_path(prim, at) for prim in _spaced(prims, MAX_PRIMS))
    for i, level in enumerate(drawn):
        x, y = GAP + i % COLUMNS * (SIDE + GAP), GAP + i // COLUMNS * (height + CAPTION + GAP)
        ended = [box for above in levels[:i] for box, is_leaf in above if is_leaf]
        rects = "".join(_rect(box, at, "#666") for box in _spaced(ended, MAX_BOXES))
        boxes = _spaced([box for box, _ in level], MAX_BOXES)
        rects += "".join(_rect(box, at, _color(k, len(boxes))) for k, box in enumerate(boxes))
        panels.append(
            f'<g transform="translate({x:g} {y:.1f})"><text y="11" fill="#ddd">level {i} · '
            f'{counted(len(level), "nodes")}</text><g transform="translate(0 {CAPTION})">'
            f'<path d="{strokes}" stroke="#8a93a6" stroke-width=".6"/>{rects}</g></g>'
        )
    more = [f"{'xyz'[across]} to the right, {'xyz'[upwards]} upwards"]
    more += [f"{counted(len(levels) - MAX_LEVELS, 'levels')} more"] if len(levels) > MAX_LEVELS else []
    more += [f"{MAX_PRIMS} of {len(prims):,} primitives"] if len(prims) > MAX_PRIMS else []
    more += [f"at most {MAX_BOXES} boxes a level"] if max(map(len, drawn)) > MAX_BOXES else []
    n_rows, n_columns = -(-len(drawn) // COLUMNS), COLUMNS if len(more) > 1 else min(len(drawn), COLUMNS)
    width, bottom = GAP + n_columns * (SIDE + GAP), GAP + n_rows * (height + CAPTION + GAP)
    size = f"{width} {bottom + CAPTION:.0f}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{bottom + CAPTION:.0f}" viewBox="0 0 {size}" '
        f'role="img" fill="none" font-family="sans-serif" font-size="11"><title>{escape(title)}</title>'
        f'<rect width="100%" height="100%" rx="8" fill="#101218"/>{"".join(panels)}'
        f'<text x="{GAP}" y="{bottom + 6:.0f}" fill="#999">{"; ".join(more)}</text></svg>'
    )


def _path(prim: Primitive, at: Callable[[Point], Pixel]) -> str:
    """Return the commands that draw a segment, or the box of another primitive; none if it is not finite."""
    if isinstance(prim, Segment):
        (x, y), (x1, y1) = at(prim.start), at(prim.end)
        return f"M{x:.1f} {y:.1f}L{x1:.1f} {y1:.1f}" if math.isfinite(x + y + x1 + y1) else ""
    box = prim.bounds()
    (x, y1), (x1, y) = at(box.lo), at(box.hi)
    return f"M{x:.1f} {y:.1f}H{x1:.1f}V{y1:.1f}H{x:.1f}Z" if math.isfinite(x + y + x1 + y1) else ""


def _rect(box: Box, at: Callable[[Point], Pixel], color: str) -> str:
    """Return a rectangle; none if the box is not finite."""
    (x, bottom), (right, y) = at(box.lo), at(box.hi)
    if not math.isfinite(x + y + right + bottom):
        return ""
    # Keep flat boxes visible.
    width, height = max(0.5, right - x), max(0.5, bottom - y)
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" stroke="{color}"/>'


def _color(index: int, count: int) -> str:
    """Return a colour whose hue follows the order in the level, so that siblings look alike, from orange on."""
    rgb = colorsys.hls_to_rgb((0.08 + 0.85 * index / count) % 1.0, 0.62, 0.9)
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in rgb)


def _spaced(items: Sequence[T], most: int) -> Sequence[T]:
    """Return up to `most` items, spaced evenly."""
    return items if len(items) <= most else [items[i * len(items) // most] for i in range(most)]
