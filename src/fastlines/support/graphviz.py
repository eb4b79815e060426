"""Trees in DOT, the language of Graphviz: ``dot -Tsvg tree.dot -o tree.svg`` draws them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy.typing as npt

from .texts import counted, number_text

Numbers: TypeAlias = npt.NDArray[Any]

#: The default of the last level that is drawn: at most 127 nodes.
MAX_LEVEL = 6


class DotNode(NamedTuple):
    """A node of a tree to draw."""

    #: The number of the node in preorder, and that of its parent; None at the root.
    number: int
    parent: int | None
    #: The lines of its label.
    label: Sequence[str]
    is_leaf: bool
    #: The number of nodes below it that are left out.
    n_left_out: int


def dot_text(name: str, nodes: Sequence[DotNode]) -> str:
    """Return a tree in DOT: leaves are ellipses, and nodes without their children have dashed frames.

    Parameters
    ----------
    name : str
        The caption begins with it.
    nodes : sequence of DotNode
        In an order in which left children precede right ones.

    Examples
    --------
    >>> print(dot_text("small", [DotNode(0, None, ["root"], False, 0), DotNode(1, 0, ["leaf"], True, 0)]))
    digraph tree {
      graph [label="small: 2 nodes"]
      node [shape=box]
      n0 [label="0: root"]
      n1 [label="1: leaf", shape=ellipse]
      n0 -> n1
    }
    <BLANKLINE>
    """
    n_left_out = sum(node.n_left_out for node in nodes)
    caption = f"{name}: {counted(len(nodes) + n_left_out, 'nodes')}"
    if n_left_out:
        caption += f", of which {n_left_out:,} are left out; raise max_level to draw them"
    lines = [f"graph [label={_quoted(caption)}]", "node [shape=box]"]
    for node in nodes:
        label = f"{node.number}: " + "\n".join(node.label)
        more = ", shape=ellipse" if node.is_leaf else ""
        if node.n_left_out:
            label += f"\n{counted(node.n_left_out, 'nodes')} below"
            more = ", style=dashed"
        lines.append(f"n{node.number} [label={_quoted(label)}{more}]")
    lines += [f"n{node.parent} -> n{node.number}" for node in nodes if node.parent is not None]
    return "digraph tree {\n" + "".join(f"  {line}\n" for line in lines) + "}\n"


def dot_nodes(
    right: Numbers, n_refs: Numbers, costs: Numbers, areas: Numbers, last: float = MAX_LEVEL
) -> list[DotNode]:
    """Return the nodes to draw of a tree in preorder, up to a level.

    Parameters
    ----------
    right : (n,) array of int
        The right child of each node; 0 for a leaf. The left child is the next node.
    n_refs, costs, areas : (n,) array
        What the label of each node says.
    last : float
        The last level.
    """
    drawn = list[DotNode]()
    # Visit in preorder: a node, its parent, its level, and where the nodes below it end.
    ahead: list[tuple[int, int | None, int, int]] = [(0, None, 0, len(right))]
    while ahead:
        node, parent, level, end = ahead.pop()
        measures = f"cost {number_text(costs[node])}, area {number_text(areas[node])}"
        label = counted(int(n_refs[node]), "references"), measures
        middle, is_last = int(right[node]), level == last
        drawn.append(DotNode(node, parent, label, middle == 0, end - node - 1 if is_last else 0))
        if middle and not is_last:
            ahead += [(middle, node, level + 1, end), (node + 1, node, level + 1, middle)]
    return drawn


def _quoted(text: str) -> str:
    """Return a text as a quoted string of DOT, on one line."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "\\n".join(escaped.splitlines()) + '"'
