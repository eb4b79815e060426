"""Pictures of the levels of a tree: its boxes over its lines, one panel a level (thesis, figures 1.1 and 1.2)."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..camera import Camera, Float64Array
from ..progress import ProgressOption
from ..tree import Tree
from .picture import depth_picture

if TYPE_CHECKING:
    from PIL import Image, ImageFont

Color: TypeAlias = tuple[int, int, int, int]

#: The twelve edges of a box, between corners numbered by their bits x, y, z.
EDGES = np.array([(a, a | bit) for bit in (1, 2, 4) for a in range(8) if not a & bit])
#: Panels are drawn this many times larger and then shrunk, for smooth lines.
SMOOTH = 2
#: The brightness of the lines behind the boxes, relative to a depth picture.
DIMMED = 0.4
#: The most boxes in a panel.
MAX_BOXES = 4096
GAP, CAPTION = 10, 26
BACKGROUND, INK, FAINT = (0, 0, 0), (235, 235, 235), (150, 150, 150, 90)


def level_sheet(
    tree: Tree,
    camera: Camera,
    radius: float,
    levels: int | Sequence[int] = 6,
    panel: int = 320,
    columns: int = 3,
    behind: Tree | None = None,
    progress: ProgressOption = False,
) -> npt.NDArray[np.uint8]:
    """Draw the boxes of some levels of a tree over its lines, a panel for each level.

    Parameters
    ----------
    tree : Tree
        Over lines.
    camera : Camera
        The direction of view; the camera moves along it until all boxes are in the picture.
    radius : float
        Half the thickness of the lines behind the boxes.
    levels : int or sequence of int
        The number of levels from the root, or the levels themselves.
    panel : int
        Width and height of a panel's picture in pixels.
    columns : int
        The number of panels side by side.
    behind : Tree, optional
        Another tree over the same lines that draws them faster.
    progress : bool or callable
        Show a bar, or call back with the fraction that is done.

    Returns
    -------
    (h, w, 3) uint8
        Boxes have colours by their order in the level. Leaves of earlier levels are grey. A tree with fewer levels has
        fewer panels.
    """
    from PIL import Image, ImageDraw

    nodes = tree.levels()
    wanted = range(levels) if isinstance(levels, int) else levels
    shown = [level for level in wanted if level < len(nodes)]
    camera = Camera.framing(tree.nodes["box"][0], camera.axes()[2], camera.up, camera.fov_degrees)
    picture = depth_picture(behind or tree, camera, panel, panel, radius, samples=2, progress=progress)
    dimmed = Image.fromarray((picture * DIMMED).astype(np.uint8))

    columns = min(columns, len(shown))
    n_rows = -(-len(shown) // columns)
    size = columns * (panel + GAP) + GAP, n_rows * (panel + CAPTION + GAP) + GAP
    sheet = Image.new("RGB", size, BACKGROUND)
    draw = ImageDraw.Draw(sheet)
    font = _font(15)
    for i, level in enumerate(shown):
        left, top = GAP + i % columns * (panel + GAP), GAP + i // columns * (panel + CAPTION + GAP)
        ended = [ids[tree.is_leaf[ids]] for ids in nodes[:level]]
        boxes = _panel(tree, camera, panel, dimmed, nodes[level], np.concatenate([*ended, nodes[0][:0]]))
        sheet.paste(boxes, (left, top + CAPTION))
        count = len(nodes[level])
        draw.text(
            (left + 4, top + CAPTION / 2),
            f"level {level} · {count:,} {'node' if count == 1 else 'nodes'}",
            fill=INK,
            font=font,
            anchor="lm",
        )
    return np.asarray(sheet)


def _panel(
    tree: Tree, camera: Camera, panel: int, dimmed: Image.Image, boxes: IntArray, ended: IntArray
) -> Image.Image:
    """Draw one level: faint leaves of earlier levels, then the boxes from the farthest edge to the nearest."""
    from PIL import Image, ImageDraw

    large = panel * SMOOTH
    image = dimmed.resize((large, large), Image.Resampling.BICUBIC).convert("RGB")
    draw = ImageDraw.Draw(image, "RGBA")
    for pixels, _ in _edges(tree, camera, large, ended[:MAX_BOXES])[0]:
        draw.line(pixels, FAINT, width=SMOOTH)

    boxes = boxes[:MAX_BOXES]
    edges, (near, far) = _edges(tree, camera, large, boxes)
    edges.sort(key=lambda edge: -edge[1][0])
    few = len(boxes) <= 64
    for pixels, (depth, box) in edges:
        nearness = (far - depth) / max(far - near, 1e-30)
        color = _color(box, len(boxes), 0.3 + 0.7 * nearness)
        draw.line(pixels, color, width=2 * SMOOTH if few and nearness > 0.5 else SMOOTH)
    return image.resize((panel, panel), Image.Resampling.LANCZOS)


Edge: TypeAlias = tuple[list[float], tuple[float, int]]


def _edges(tree: Tree, camera: Camera, size: int, boxes: IntArray) -> tuple[list[Edge], tuple[float, float]]:
    """Project the edges of boxes: both ends in pixels, depth of the middle and box of each, and the range of depths."""
    if len(boxes) == 0:
        return [], (0.0, 0.0)
    corners = _corners(tree.nodes["box"][boxes].astype(np.float64))
    pixels, depth = camera.project(corners.reshape(-1, 3), size, size)
    pixels, depth = pixels.reshape(-1, 8, 2), depth.reshape(-1, 8)
    ends = pixels[:, EDGES].reshape(-1, 4)
    middles = depth[:, EDGES].mean(axis=2).ravel()
    owners = np.repeat(np.arange(len(boxes)), len(EDGES))
    seen = np.isfinite(ends).all(axis=1)
    edges = [
        (line, (middle, owner))
        for line, middle, owner in zip(ends[seen].tolist(), middles[seen].tolist(), owners[seen].tolist(), strict=True)
    ]
    return edges, (float(middles.min()), float(middles.max()))


def _corners(boxes: Float64Array) -> Float64Array:
    """Return all corners of boxes (k, 2, 3), as (k, 8, 3)."""
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    return boxes[:, bits, np.arange(3)]


def _color(index: int, count: int, strength: float) -> Color:
    """Return a colour whose hue follows the order in the level, so that siblings look alike, from orange on."""
    hue = (0.08 + 0.85 * index / max(count, 1)) % 1.0
    r, g, b = colorsys.hls_to_rgb(hue, 0.62, 0.9)
    return round(255 * r), round(255 * g), round(255 * b), round(255 * strength)


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    from PIL import ImageFont

    return ImageFont.load_default(size)
