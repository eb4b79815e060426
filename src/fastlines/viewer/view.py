"""``fl.view``: show a tree in the browser; and what a page shows first."""

from __future__ import annotations

import numpy as np

from ..arrays import count, number
from ..builder import build
from ..errors import InputError
from ..forest.forest import Forest
from ..theory.node import Node
from ..tree import Tree
from .choices import Choices
from .line_colors import check_color
from .pane import Pane
from .scene_frame import SceneFrame
from .server import viser
from .viewer import Viewer

#: The radius of rays through lines that have none of their own, as a fraction of the longest side of the scene.
SMALL = 0.002
#: The level that is shown first is the last one before there are more nodes than this.
FEW_BOXES = 16
#: What to do instead of viewing what is no tree, by its class.
INSTEAD = {
    Forest: "a page shows one tree; build one over some of the lines",
    Node: "fl.drawing draws trees of fl.theory",
}


def view(
    tree: Tree,
    *,
    against: Tree | str | None = None,
    color: str | None = None,
    level: int | None = None,
    radius: float | None = None,
    port: int | None = None,
) -> Viewer:
    """Show a tree in the browser: its lines, its boxes, and the way of a ray through it.

    The page is served on the loopback address only, by a thread, until `Viewer.close` or the end of the program. It
    needs the extra ``fastlines[view]``. In a notebook, the viewer shows itself.

    Parameters
    ----------
    tree : Tree
    against : Tree or str, optional
        A second tree over the same lines, or the method to build it by. A ray is shot into both.
    color : str, optional
        What colours of lines depend on: "direction", "strand", "depth", "leaf size", "cost", "radius", or an attribute.
    level : int, optional
        The level whose boxes are shown; by default one with a few of them.
    radius : float, optional
        How near to a ray lines are hit, until the page changes it; by default a little for lines without a radius of
        their own, and else 0.
    port : int, optional
        By default the first free one from 8080 on; 0 takes any.

    Raises
    ------
    InputError
        If the tree has no primitives, the second one is over others, there is no such colour or level, or the port is
        in use.
    MissingExtraError
        If viser is not installed.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.scenes.make("spaghetti", 300).lines
    >>> with fl.view(fl.build(lines, "bvh-d2"), against="bvh-cl") as viewer:  # doctest: +SKIP
    ...     viewer.shoot([0.5, 0.5, -1], [0, 0, 1], radius=0.01)
    ...     input(viewer.url)
    """
    viser()  # before the work
    panes = make_panes(tree, against)
    return Viewer(panes, first_choices(panes, color, level, radius), port)


def make_panes(tree: Tree, against: Tree | str | None = None) -> list[Pane]:
    """Check the trees of a page, and build the second one if a method is named.

    The costs of both are those of the first one's steps and tests, so that they can be compared.
    """
    _check_tree(tree, "tree")
    geometry = tree.geometry
    if not len(geometry):
        raise InputError("the tree is over no primitives, so there is nothing to view; expected at least one")
    trees = [tree]
    tree.layout  # noqa: B018 - the first ray would wait for it
    if isinstance(against, str):
        trees.append(build(geometry, against))
    elif against is not None:
        _check_tree(against, "against")
        other = against.geometry
        if len(other) != len(geometry) or not np.array_equal(other.bounds, geometry.bounds):
            raise InputError(
                f"against is over {other.count_text()}, and the tree over {geometry.count_text()}; expected a second "
                "tree over the same lines"
            )
        trees.append(against)
    for each in trees[1:]:
        each.layout  # noqa: B018
    names = [each.method for each in trees]
    if len(set(names)) < len(names):
        names = [f"{name} {i}" for i, name in enumerate(names, 1)]
    model = tree.settings.cost
    return [Pane(each, name, f"/{i}", model) for i, (each, name) in enumerate(zip(trees, names, strict=True))]


def _check_tree(tree: object, name: str) -> None:
    if isinstance(tree, Tree):
        return
    hint = INSTEAD.get(type(tree), "build one first, as in fl.view(fl.build(lines))")
    raise InputError(f"{name} is {type(tree).__name__}; expected a Tree: {hint}")


def first_choices(
    panes: list[Pane], color: str | None = None, level: int | None = None, radius: float | None = None
) -> Choices:
    """Return what a page shows first."""
    choices, tree = Choices(), panes[0].tree
    if radius is None:
        radius = SMALL * SceneFrame.around(tree).size if tree.geometry.needs_radius else 0.0
    choices.radius = float(f"{number('radius', radius, 'a number from 0', 0.0):.4g}")
    if color is not None:
        choices.color = check_color(color, panes[0].tree.geometry)
    levels = max((pane.outline.levels for pane in panes), key=len)
    many = [i for i, nodes in enumerate(levels) if len(nodes) > FEW_BOXES]
    choices.level = many[0] - 1 if many else len(levels) - 1
    if level is not None:
        choices.level = count("level", level, 0, len(levels) - 1)
    return choices
