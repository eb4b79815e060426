"""The letters of nodes, which are the same in a partition and in the graph beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import IntArray, count
from ..errors import InputError
from ..inspection.outline import Outline
from ..support.texts import counted

#: The most nodes that have letters: of more, a figure is too crowded to read.
MAX_NODES = 63


@dataclass(frozen=True)
class Lettered:
    """The nodes of the first levels of a tree, and a letter for each.

    Attributes
    ----------
    nodes : (k,) int64
        Level by level, from the left to the right.
    letters : dict of int to str
        By the number of the node: A for the root, then B, C, ….
    last : int
        The last level.
    left_out : int
        How many nodes are below it.
    """

    nodes: IntArray
    letters: dict[int, str]
    last: int
    left_out: int

    @property
    def notes(self) -> list[str]:
        """What is left out, in words."""
        return [f"levels 0 to {self.last}; {counted(self.left_out, 'nodes')} below"] if self.left_out else []


def lettered(outline: Outline, max_level: int | None = None) -> Lettered:
    """Choose the nodes of a figure with letters.

    Parameters
    ----------
    outline : Outline
    max_level : int, optional
        The last level; by default as many as have at most `MAX_NODES` nodes.

    Raises
    ------
    InputError
        If the levels that are asked for have more nodes.
    """
    levels = outline.levels
    sizes = np.cumsum([len(nodes) for nodes in levels])
    fitting = int((sizes <= MAX_NODES).sum()) - 1
    last = fitting if max_level is None else min(count("max_level", max_level, 0), len(levels) - 1)
    if last > fitting:
        raise InputError(
            f"max_level={max_level} has {sizes[last]:,} nodes; a figure with letters has at most {MAX_NODES}, so the "
            f"last level is {fitting} here; fl.drawing.draw_levels draws more boxes"
        )
    nodes = np.concatenate(levels[: last + 1])
    letters = {node: letter(i) for i, node in enumerate(nodes.tolist())}
    return Lettered(nodes, letters, last, outline.n_nodes - len(nodes))


def kind_of(outline: Outline) -> str:
    """Return what a tree is, for titles; one leaf is a BVH and a KD tree."""
    if outline.n_nodes == 1:
        return "One leaf"
    return "KD tree" if outline.is_kd else "BVH"


def letter(number: int) -> str:
    """Return A to Z, AA, AB, … for 0, 1, ….

    Examples
    --------
    >>> letter(0), letter(25), letter(26), letter(62)
    ('A', 'Z', 'AA', 'BK')
    """
    first, second = divmod(number, 26)
    return (letter(first - 1) if first else "") + chr(ord("A") + second)
