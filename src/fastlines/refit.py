"""Refits of a tree whose lines have moved, and the policy that decides when a new build pays."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from . import _core
from .arrays import LEAST, number
from .engines import engine
from .geometry.any_geometry import AnyGeometry
from .progress import ProgressCallback, ProgressOption, reporting
from .structure.frame import frame_around
from .structure.layout import refit_layout
from .structure.tree_data import NODE, TreeData
from .support.immutable import own
from .threads import get_num_threads

Tree = TypeVar("Tree", bound=TreeData)

#: Trees of fewer references are refitted on one thread: starting more would take as long.
SHORT_REFIT = 20_000

SECONDS = "a time in seconds, 0 or more"


def refitted(tree: Tree, lines: AnyGeometry, cost: float, progress: ProgressOption) -> Tree:
    """Refit a tree, and its layout if it has one, to lines that have moved.

    The result is a BVH, which measures its growth from `cost`. It needs no check: the core has made its nodes, and the
    rest comes from the tree.
    """
    with reporting(progress, "refit") as callback:
        nodes = _refit_nodes(tree, lines, callback)
        values = {field.name: getattr(tree, field.name) for field in fields(tree)}
        frame_around(nodes["box"][0], tree.frame)
        values |= {"geometry": lines, "nodes": nodes, "built_cost": cost}
        if tree.settings.boxes != "tight":
            values |= {"settings": replace(tree.settings, boxes="tight"), "method": "custom"}
        if "layout" in tree.__dict__:
            values["layout"] = refit_layout(tree.__dict__["layout"], lines, nodes["box"][0], _n_threads(tree), callback)
    made = object.__new__(type(tree))
    made.__dict__.update(values)
    return made


def _refit_nodes(tree: TreeData, lines: AnyGeometry, progress: ProgressCallback | None) -> npt.NDArray[Any]:
    """Return the tree's nodes with boxes tight around lines that have moved."""
    words = engine.refit_tree(lines.build_data()[1], *tree.words(), _n_threads(tree), progress)
    return own(words).reshape(-1).view(NODE)


def _n_threads(tree: TreeData) -> int:
    return 1 if tree.n_refs < SHORT_REFIT else get_num_threads()


def built_cost(tree: TreeData) -> float:
    """Return the cost that `TreeData.growth` is relative to: of a KD tree, the cost with tight boxes, as of a refit."""
    if tree.built_cost is not None:
        return tree.built_cost
    nodes = tree.words()[0]
    if tree.settings.boxes == "cut":
        nodes = _refit_nodes(tree, tree.geometry, None).view(np.uint32).reshape(-1, 9)
    return _core.cost(nodes, tree.settings.cost.c_trav, tree.settings.cost.c_prim)


@dataclass
class RebuildPolicy:
    """Build anew as soon as queries have lost, since the last build, the time that a build takes.

    A query on a refitted tree takes about `Tree.growth` times as long as it would if the cost had not grown. So the
    fraction 1 − 1/growth of the time of queries is lost. The policy waits until the losses add up to one build. Losses
    and builds together then take at most twice as long as with the best schedule in hindsight, apart from the loss of
    the frame before each build.

    Parameters
    ----------
    build_seconds : float
        How long a build takes, with the layout.
    lost_seconds : float
        The time that has been lost since the last build.

    Examples
    --------
    >>> import fastlines as fl
    >>> tree, rule = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]]), RebuildPolicy(build_seconds=1.0)
    >>> tree = tree.refit([[[0, 0, 0], [1, 1, 2]], [[8, 8, 8], [9, 9, 9]]])
    >>> if rule.due(tree, query_seconds=0.5):
    ...     tree = fl.build(tree.geometry)
    """

    build_seconds: float
    lost_seconds: float = 0.0

    def __post_init__(self) -> None:
        self.build_seconds = number("build_seconds", self.build_seconds, "a time in seconds, above 0", LEAST)
        self.lost_seconds = number("lost_seconds", self.lost_seconds, SECONDS, 0.0)

    def due(self, tree: TreeData, query_seconds: float) -> bool:
        """Add the time that queries on a tree have lost; return whether to build anew now, and if so, start from 0.

        Parameters
        ----------
        tree : Tree
            The tree that the queries ran on.
        query_seconds : float
            The time that the queries took.
        """
        query_seconds = number("query_seconds", query_seconds, SECONDS, 0.0)
        self.lost_seconds += query_seconds * max(0.0, 1 - 1 / tree.growth)
        due = self.lost_seconds >= self.build_seconds
        if due:
            self.lost_seconds = 0.0
        return due
