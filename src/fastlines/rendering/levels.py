"""Pictures of the levels of a tree: its boxes over its lines, one panel a level (thesis, figures 1.1 and 1.2)."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..camera import Camera
from ..progress import ProgressOption
from ..tree import Tree
from .renderer import render
from .shading.depth import check_radius
from .shading.depth_tone import grey
from .shading.own_frame import in_own_frame

if TYPE_CHECKING:
    from PIL import Image

#: The twelve edges of a box, between corners numbered by their bits x, y, z.
EDGES = np.array([(a, a | bit) for bit in (1, 2, 4) for a in range(8) if not a & bit])
#: Panels are drawn this many times larger and then shrunk, for smooth lines.
SMOOTH = 2
#: The samples of a pixel of the lines behind the boxes.
SAMPLES = 4
#: The brightness of the lines behind the boxes, relative to a depth picture.
DIMMED = 0.4
#: The most boxes in a panel.
MAX_BOXES = 4096
GAP, CAPTION = 10, 26
BACKGROUND, INK, FAINT = (0, 0, 0), (235, 235, 235), (150, 150, 150, 90)


def level_sheet(
    tree: Tree,
    camera: Camera,
    radius: float | None = None,
    levels: int | Sequence[int] = 6,
    panel: int = 320,
    columns: int = 3,
    behind: Tree | None = None,
    progress: ProgressOption = False,
) -> npt.NDArray[np.uint8]:
    """Draw the boxes of some levels of a tree over its lines, a panel for each level.

    Parameters
    ----------
    tree, radius, progress
        As in `depth_image`; the radius is that of the lines behind the boxes.
    camera : Camera
        The direction of view; the camera moves along it until all boxes are in the picture.
    levels : int or sequence of int
        The number of levels from the root, or the levels themselves.
    panel, columns : int
        Width and height of a panel's picture in pixels, and the number of panels side by side.
    behind : Tree, optional
        Another tree over the same lines that draws them faster.

    Returns
    -------
    (h, w, 3) uint8
        Boxes are coloured by their order in the level. Leaves of earlier levels are grey. A tree with fewer levels has
        fewer panels.
    """
    from PIL import Image, ImageDraw, ImageFont

    tree, camera = in_own_frame(tree, camera)
    nodes = tree.levels()
    wanted = range(levels) if isinstance(levels, int) else levels
    shown = [level for level in wanted if level < len(nodes)]
    camera = Camera.framing(tree.box, camera.axes()[2], camera.up, camera.fov_degrees)
    radius, drawn = check_radius(tree, radius), (behind or tree).without_offset()
    square: dict[str, Any] = {"width": panel, "height": panel}
    lines = grey(render(drawn, camera, look="depth", radius=radius, samples=SAMPLES, progress=progress, **square))
    dimmed = Image.fromarray((lines * DIMMED).astype(np.uint8))

    columns = min(columns, len(shown))
    n_rows = -(-len(shown) // columns)
    size = columns * (panel + GAP) + GAP, n_rows * (panel + CAPTION + GAP) + GAP
    sheet = Image.new("RGB", size, BACKGROUND)
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(15)
    for i, level in enumerate(shown):
        left, top = GAP + i % columns * (panel + GAP), GAP + i // columns * (panel + CAPTION + GAP)
        ended = [ids[tree.is_leaf[ids]] for ids in nodes[:level]]
        boxes = _panel(tree, camera, panel, dimmed, nodes[level], np.concatenate([*ended, nodes[0][:0]]))
        sheet.paste(boxes, (left, top + CAPTION))
        count = len(nodes[level])
        text = f"level {level} · {count:,} {'node' if count == 1 else 'nodes'}"
        draw.text((left + 4, top + CAPTION / 2), text, fill=INK, font=font, anchor="lm")
    return np.asarray(sheet)


def _panel(
    tree: Tree, camera: Camera, panel: int, dimmed: Image.Image, boxes: IntArray, ended: IntArray
) -> Image.Image:
    """Draw one level: faint leaves of earlier levels, then the boxes from the farthest edge to the nearest."""
    from PIL import Image, ImageDraw

    large = panel * SMOOTH
    image = dimmed.resize((large, large), Image.Resampling.BICUBIC).convert("RGB")
    draw = ImageDraw.Draw(image, "RGBA")
    box = tree.nodes["box"]
    for _, _, pixels in box_edges(box[ended[:MAX_BOXES]], camera, large, large):
        draw.line(pixels, FAINT, width=SMOOTH)
    boxes = boxes[:MAX_BOXES]
    edges = box_edges(box[boxes], camera, large, large)
    few = len(boxes) <= 64
    for depth, i, pixels in edges:
        far, near = edges[0][0], edges[-1][0]
        nearness = (far - depth) / max(far - near, 1e-30)
        color = box_color(i, len(boxes), 0.3 + 0.7 * nearness)
        draw.line(pixels, color, width=2 * SMOOTH if few and nearness > 0.5 else SMOOTH)
    return image.resize((panel, panel), Image.Resampling.LANCZOS)


def box_edges(boxes: FloatArray, camera: Camera, width: int, height: int) -> list[tuple[float, int, list[float]]]:
    """Project the edges of boxes (n, 2, 3), the farthest first: depth of the middle, box, both ends in pixels."""
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    corners = boxes.astype(np.float64)[:, bits, np.arange(3)]
    pixels, depth = camera.project(corners.reshape(-1, 3), width, height)
    ends = pixels.reshape(-1, 8, 2)[:, EDGES].reshape(-1, 4)
    middles = depth.reshape(-1, 8)[:, EDGES].mean(axis=2).ravel()
    owners = np.repeat(np.arange(len(boxes)), len(EDGES))
    order = np.argsort(-middles, kind="stable")
    order = order[np.isfinite(ends[order]).all(axis=1)]
    return list(zip(middles[order].tolist(), owners[order].tolist(), ends[order].tolist(), strict=True))


def box_color(index: int, count: int, strength: float) -> tuple[int, int, int, int]:
    """Return a colour whose hue follows the order in the level, so that siblings look alike, from orange on."""
    hue = (0.08 + 0.85 * index / max(count, 1)) % 1.0
    r, g, b = colorsys.hls_to_rgb(hue, 0.62, 0.9)
    return round(255 * r), round(255 * g), round(255 * b), round(255 * strength)
