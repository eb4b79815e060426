"""The work of a picture: what the ray of each pixel visits in a tree."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..arrays import choice, count, instance, number
from ..camera import Camera
from ..geometry.any_geometry import AnyGeometry
from ..geometry.boxes import Boxes
from ..geometry.hit_places import Float64Array
from ..geometry.lines import Lines
from ..inspection.outline import Outline, outline_of
from ..progress import ProgressOption, reporting
from ..rendering import default_camera
from ..rendering.node_visits import sum_over_visits
from ..settings.settings import Cost
from ..structure.tree_data import TreeData
from ..support.texts import number_text
from ..theory.primitive import Segment
from .axes import axes_of, describe, without_frame
from .subject import AnyTree, require_boxes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: What is added up along a ray: nodes, or what they cost.
MEASURES = ("nodes", "cost")
#: The colour map of the rendering's look "work", and the quantile that has its last colour.
MAP, BRIGHT = "inferno", 0.995
#: The size of the colour bar, which is about as high as a square image, and its distance.
BAR: dict[str, Any] = {"fraction": 0.046, "pad": 0.03}
#: The most pixels a side.
MAX_SIZE = 2048


def draw_work(
    tree: AnyTree,
    *,
    by: Literal["nodes", "cost"] = "nodes",
    camera: Camera | None = None,
    size: int = 192,
    radius: float = 0.0,
    most: float | None = None,
    model: Cost | None = None,
    progress: ProgressOption = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw how many nodes the ray of each pixel visits, or what they cost.

    The rays find all hits, and visit each node whose box they hit. It is the picture of ``fl.render(tree,
    look="work")``, as an image with a scale, and for trees of the theory too.

    Parameters
    ----------
    tree : Tree or theory.Node
    by : {"nodes", "cost"}
        The number of nodes; or steps and tests, each times its cost, as in `inspection.Traversal.cost`.
    camera : Camera, optional
        By default the one of pictures, `fastlines.default_camera`.
    size : int
        The pixels a side.
    radius : float
        That of the query, by which boxes are grown.
    most : float, optional
        The number that has the brightest colour; by default the 99.5 % quantile of pixels that hit something. With the
        same number, two trees can be compared.
    model : Cost, optional
        The costs of a step and of a test; by default those of the build.
    progress : bool or callable
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Their image has the numbers: ``ax.images[0].get_array()``.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")
    >>> fl.drawing.draw_work(tree, size=8).images[0].get_array().shape
    (8, 8)
    """
    axes, outline = axes_of(ax, 5.6, 4.8), outline_of(tree, model)
    require_boxes(outline)
    work = work_of_pixels(tree, outline, choice("by", by, MEASURES), camera, size, radius, progress)
    hit = work[work > 0]
    brightest = most if most is not None else float(np.quantile(hit, BRIGHT)) if len(hit) else 1.0
    number("most", brightest, "a number above 0", 1e-300)
    image = axes.imshow(work, cmap=MAP, vmin=0, vmax=brightest, interpolation="nearest")
    without_frame(axes)
    color = axes.title.get_color()
    bar = axes.figure.colorbar(image, ax=axes, extend="max" if work.max() > brightest else "neither", **BAR)
    bar.set_label("nodes visited by a ray" if by == "nodes" else "cost of a ray: its steps and tests", color=color)
    bar.ax.tick_params(colors=color)
    mean = number_text(float(hit.mean()) if len(hit) else 0.0)
    title = f"{outline.name}: {mean} nodes a ray" if by == "nodes" else f"{outline.name}: cost {mean} a ray"
    through = [f"radius {radius:g}"] if radius else []
    describe(axes, title, [*through, "mean of the pixels that hit the root's box"])
    return axes


def work_of_pixels(
    tree: AnyTree,
    outline: Outline,
    by: str = "nodes",
    camera: Camera | None = None,
    size: int = 192,
    radius: float = 0.0,
    progress: ProgressOption = False,
) -> Float64Array:
    """Return the work of each pixel of a square picture, (size, size) float64."""
    count("size", size, 1, MAX_SIZE)
    number("radius", radius, "a finite number that is 0 or more", 0.0)
    geometry, offset = geometry_of(tree), np.zeros(3)
    if camera is None:
        camera = default_camera(geometry.without_offset())
    else:
        instance("camera", camera, Camera, "a Camera")
        offset = np.array(geometry.offset)
    rays = camera.rays(width=size, height=size)
    origins, directions = (np.asarray(array, np.float64).reshape(-1, 3) for array in rays)
    weights = outline.own_cost / np.where(outline.chance > 0, outline.chance, 1) if by == "cost" else None
    grow = radius + geometry.radius_beyond
    boxes, right = outline.boxes, outline.right
    with reporting(progress, "work") as callback:
        work = sum_over_visits(boxes, right, origins - offset, directions, grow, weights, callback)
    return work.reshape(size, size)


def geometry_of(tree: AnyTree) -> AnyGeometry:
    """Return what a tree is over: of a tree of the theory its segments, or else the boxes of its primitives."""
    if isinstance(tree, TreeData):
        return tree.geometry
    ends = [(prim.start, prim.end) for prim in tree.prims if isinstance(prim, Segment)]
    if len(ends) == len(tree.prims):
        return Lines.from_segments(ends)
    return Boxes([prim.bounds() for prim in tree.prims])
