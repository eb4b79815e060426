"""Thumbnails: a small picture of any geometry or tree, drawn without rays, so that no tree is built for it.

Lines are strokes from the farthest to the nearest, as wide as they are thick. Their colour is the direction: red along
x, green along y, blue along z. What is farther away is darker. Triangles and boxes are shaded by their normal. Of a
tree, boxes of an early level are drawn over its lines.
"""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...camera import Camera
from ...geometry.any_geometry import AnyGeometry
from ...geometry.collection import Geometry
from ...structure.tree_data import TreeData
from ..default_view import default_view
from ..levels import box_color, box_edges
from .sketch import Sketch

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

Float64Array = npt.NDArray[np.float64]

#: The size of a thumbnail in pixels, and how many times larger it is drawn first, for smooth lines.
WIDTH, HEIGHT, SMOOTH = 320, 240, 2
BACKGROUND = (16, 18, 24)
#: Colours of what has no direction: spheres and points, and the sides of triangles and boxes.
BALL, SIDE = (0.95, 0.85, 0.7), (0.62, 0.72, 0.85)
#: The brightness of what is farthest, and of the geometry below the boxes of a tree.
FARTHEST, BELOW_BOXES = 0.4, 0.6
#: The most boxes of a tree that are drawn: those of its last level that has no more nodes.
MAX_BOXES = 12
#: The number of colours of the PNG.
COLORS = 128


class Shapes(NamedTuple):
    """Strokes of two points, or polygons of three or four, as they are drawn."""

    pixels: Float64Array
    depth: Float64Array
    width: Float64Array
    color: Float64Array


def draw_sketch(
    drawn: Sketch, tree: TreeData | None = None, width: int = WIDTH, height: int = HEIGHT
) -> Image.Image | None:
    """Draw a sample of a geometry by the default camera, and boxes of a tree over it; None if there is nothing to draw.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.rendering.card.sketch import sketch
    >>> draw_sketch(sketch(fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]]))).size
    (320, 240)
    """
    from PIL import Image, ImageDraw

    parts = [part for part in drawn.parts if len(part)]
    if not parts:
        return None
    seen = Geometry(parts)
    beyond = (seen if tree is None else tree.geometry).radius_beyond
    framed = seen if tree is None else np.add(tree.box, [[-beyond], [beyond]])
    camera = Camera.framing(framed, *default_view(seen), aspect=width / height)
    large = width * SMOOTH, height * SMOOTH
    image = Image.new("RGB", large, BACKGROUND)
    canvas = ImageDraw.Draw(image)
    shapes = [_shapes(part, camera, *large, drawn.n_drawn) for part in parts]
    _draw(canvas, shapes, 1.0 if tree is None else BELOW_BOXES)
    if tree is not None:
        _draw_boxes(canvas, tree, camera, *large)
    return image.resize((width, height), Image.Resampling.LANCZOS)


def to_png(image: Image.Image) -> bytes:
    """Write a picture as a PNG of few colours, which is several times smaller."""
    stream = io.BytesIO()
    image.quantize(COLORS).save(stream, "PNG", optimize=True)
    return stream.getvalue()


def _shapes(part: AnyGeometry, camera: Camera, width: int, height: int, n_drawn: int) -> Shapes:
    """Project what is to be drawn of a part."""
    corners, radii = part.outlines()
    if corners.shape[1] == 2:
        return _strokes(corners, radii, camera, width, height, n_drawn)
    pixels, depth = camera.project(corners.reshape(-1, 3), width, height)
    n, k = corners.shape[:2]
    normals = np.cross(_unit(corners[:, 1] - corners[:, 0]), _unit(corners[:, 2] - corners[:, 0]))
    facing = np.abs((_unit(normals) * camera.axes()[2]).sum(axis=1))
    color = (0.35 + 0.65 * facing)[:, None] * SIDE
    return Shapes(pixels.reshape(n, 2 * k), depth.reshape(n, k).mean(axis=1), np.zeros(n), color)


def _strokes(ends: Float64Array, radii: Float64Array, camera: Camera, width: int, height: int, n_drawn: int) -> Shapes:
    pixels, depths = camera.project(ends.reshape(-1, 3), width, height)
    depth = depths.reshape(-1, 2).mean(axis=1)
    tangents = np.abs(_unit(ends[:, 1] - ends[:, 0]))
    color = np.where(tangents.any(axis=1, keepdims=True), 0.3 + 0.7 * tangents, BALL)
    scale = height / (2 * math.tan(math.radians(camera.fov_degrees) / 2) * depth)
    thickness = 2 * radii.mean(axis=1) * scale
    return Shapes(pixels.reshape(-1, 4), depth, np.maximum(thickness, SMOOTH if n_drawn <= 4000 else 1), color)


def _draw(canvas: ImageDraw.ImageDraw, shapes: list[Shapes], strength: float) -> None:
    """Draw all shapes, the farthest first."""
    depth = np.concatenate([part.depth for part in shapes])
    near, far = depth.min(), depth.max()
    nearness = (far - depth) / (far - near) if far > near else np.ones(len(depth))
    light = strength * (FARTHEST + (1 - FARTHEST) * nearness)
    color = (255 * light[:, None] * np.concatenate([part.color for part in shapes])).astype(int).tolist()
    width = np.rint(np.concatenate([part.width for part in shapes])).astype(int).tolist()
    pixels: list[list[float]] = [row for part in shapes for row in part.pixels.tolist()]
    for i in np.argsort(-depth, kind="stable").tolist():
        if len(pixels[i]) > 4:
            canvas.polygon(pixels[i], tuple(color[i]), tuple(color[i]))
        elif width[i] < 4:
            canvas.line(pixels[i], tuple(color[i]), width[i])
        else:
            _draw_thick(canvas, pixels[i], color[i], width[i])


def _draw_thick(canvas: ImageDraw.ImageDraw, ends: list[float], color: list[int], width: int) -> None:
    """Draw a stroke with round ends, lighter towards its middle, as if lit from the upper left."""
    for part, light in ((1.0, 0.55), (0.7, 0.8), (0.35, 1.0)):
        fill = tuple(int(light * channel) for channel in color)
        r = part * width / 2
        lit = [value - 0.4 * (width / 2 - r) for value in ends]
        canvas.line(lit, fill, max(1, round(part * width)))
        for x, y in (lit[:2], lit[2:]):
            canvas.ellipse((x - r, y - r, x + r, y + r), fill)


def _draw_boxes(canvas: ImageDraw.ImageDraw, tree: TreeData, camera: Camera, width: int, height: int) -> None:
    """Draw the boxes of a level with few nodes, and leaves above it."""
    right = tree.nodes["right"]
    level = np.zeros(1, np.int64)
    while True:
        inner = level[right[level] > 0]
        below = np.sort(np.concatenate([level[right[level] == 0], inner + 1, right[inner].astype(np.int64)]))
        if not len(inner) or len(below) > MAX_BOXES:
            break
        level = below
    for _, box, pixels in box_edges(tree.nodes["box"][level], camera, width, height):
        canvas.line(pixels, box_color(box, len(level), 1.0)[:3], SMOOTH)


def _unit(vectors: Float64Array) -> Float64Array:
    """Return unit vectors; those of length zero stay zero. Scale first, so that no square under- or overflows."""
    largest: Any = np.abs(vectors).max(axis=1, keepdims=True, initial=0)
    scaled = np.divide(vectors, largest, out=np.zeros_like(vectors), where=largest > 0)
    length = np.sqrt((scaled**2).sum(axis=1, keepdims=True))
    return np.asarray(np.divide(scaled, length, out=np.zeros_like(scaled), where=length > 0))
