"""The path from the root to a node, and the references at or below it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import IntArray
from ..geometry.any_geometry import AnyGeometry
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline
from ..rendering.card.sketch import spaced_rows
from ..support.distinct import distinct
from ..support.texts import counted
from .strokes import strokes_of_prims
from .tables import Table

#: The most references of a node on the page.
MAX_REFS = 20_000


def path_table(outline: Outline, node: int) -> Table:
    """Return a row for each node from the root to a node: the size of its box, and its share of the tree's cost.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> path_table(outline_of(tree), 1).rows
    [['0', '0', '9 × 9 × 9', '2', '100 %'], ['1', '1', '1 × 1 × 1', '1', '9.9 %']]
    """
    share = outline.cost_below / outline.cost_below[0] if outline.cost_below[0] > 0 else np.ones(outline.n_nodes)
    rows = []
    for each in outline.path(node).tolist():
        size = " × ".join(f"{side:.3g}" for side in outline.boxes[each, 1] - outline.boxes[each, 0])
        rows.append(
            [str(each), str(outline.level[each]), size, f"{outline.n_refs[each]:,}", f"{100 * share[each]:.3g} %"]
        )
    return Table(["node", "level", "box", "references", "cost"], rows)


def reference_strokes(
    geometry: AnyGeometry, outline: Outline, nodes: Sequence[int] | IntArray, most: int = MAX_REFS
) -> Float64Array:
    """Return strokes for the references at or below some nodes, (n, 2, 3): of cut lines, the pieces only.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
    >>> reference_strokes(tree.geometry, outline_of(tree), [2]).tolist()
    [[[8.0, 8.0, 8.0], [9.0, 9.0, 9.0]]]
    """
    every = np.arange(len(outline.prims))
    refs = np.concatenate([every[:0], *(every[outline.refs_of(node)] for node in nodes)])
    refs = refs[spaced_rows(len(refs), most)]
    rows, spans = outline.prims[refs], np.clip(outline.spans[refs], 0, 1)
    found, first = [np.empty((0, 2, 3))], 0
    for part in geometry.each_part():
        here = (first <= rows) & (rows < first + len(part.owner))
        of_part, first = rows[here] - first, first + len(part.owner)
        axes = part.thick_axes() if part.has_directions else None
        if axes is None:
            found.append(strokes_of_prims(part, distinct(part.owner[of_part])))
            continue
        ends = axes[0][of_part].astype(np.float64)
        along = ends[:, 1] - ends[:, 0]
        found.append(ends[:, :1] + spans[here][:, :, None] * along[:, None])
    return np.concatenate(found)


def references_text(outline: Outline, node: int, most: int = MAX_REFS) -> str:
    """Return how many references there are at or below a node, and how many are shown."""
    n_refs = int(outline.n_refs[node])
    kind = "leaf" if outline.is_leaf[node] else "inner node"
    shown = f"; {most:,} are shown" if n_refs > most else ""
    return f"{kind} {node}: {counted(n_refs, 'references')}{shown}"
