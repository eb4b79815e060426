"""The thesis's chapters 3 and 4 as short, slow Python: what a tree is, what it costs, how to build it.

The core does the same a thousand times faster and is tested against this code node for node. So values that the core
stores as float32 are rounded to float32 here too (`f32`). The limits `max_refs` and `max_leaf_refs` are left out.

======================  =====================================================================================
thesis                  here
======================  =====================================================================================
§3.1 primitive          `Primitive`: anything with an id, `bounds` and `clip`; `Segment`, `Block`, `Cone`, your own
§3.1 box, SA, AABB      `Box`, `Box.area`, `hull`
§3.2 acceleration tree  `Node`; axioms 1 to 5, BVH and KD axiom, and Theorem 4: `check`
§3.3 cost f₀ and g      `f`, `g`; Theorem 1: f = g; Theorem 3: neither reads the primitives of an inner node
§4.1 the algorithm      `best_split` and `build`; lookahead 1 is SAH (§1.5); where it ends: §1.4.2
§4.1 SPLITS             a generator over (prims, box): `object_sweep`, `plane_grid`, `plane_events`, `median`,
                        `middle`, a `union` of them, or your own; with box rule `tight` (BVH) or `cut` (KD)
§6.6 open questions     `prune`; optimal trees and bounds are in the benchmarks
                        (`fastlines_bench.studies.optimum`)
======================  =====================================================================================

The diagonals of a cube in a KD tree, whose planes cut boxes in the middle. SAH sees no gain and makes a leaf:

>>> from functools import partial
>>> ends = [[[0, 0, 0], [8, 8, 8]], [[0, 8, 0], [8, 0, 8]], [[0, 0, 8], [8, 8, 0]], [[8, 0, 0], [0, 8, 8]]]
>>> for lookahead in 1, 2:
...     tree = build(segments(ends), partial(middle, rule=cut), lookahead, c_trav=0.2)
...     check(tree, segments(ends), cut)
...     print(len(tree.nodes()), round(f(tree, c_trav=0.2), 6), round(g(tree, c_trav=0.2), 6))
1 4.0 4.0
15 2.8 2.8
"""

from .builder import Best, best_split, build, prune
from .cone import Cone, cones
from .node import Node, chance, check, covered, f, g, laws
from .primitive import Block, Box, Point, Primitive, Prims, Segment, f32, hull, put, segments
from .splits import (
    BoxRule,
    Split,
    Splits,
    at_object,
    at_plane,
    by_centre,
    cut,
    divide,
    median,
    middle,
    object_sweep,
    plane_events,
    plane_grid,
    tight,
    union,
)

__all__ = [
    "Best",
    "Block",
    "Box",
    "BoxRule",
    "Cone",
    "Node",
    "Point",
    "Primitive",
    "Prims",
    "Segment",
    "Split",
    "Splits",
    "at_object",
    "at_plane",
    "best_split",
    "build",
    "by_centre",
    "chance",
    "check",
    "cones",
    "covered",
    "cut",
    "divide",
    "f",
    "f32",
    "g",
    "hull",
    "laws",
    "median",
    "middle",
    "object_sweep",
    "plane_events",
    "plane_grid",
    "prune",
    "put",
    "segments",
    "tight",
    "union",
]
