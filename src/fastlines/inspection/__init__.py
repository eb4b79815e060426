"""What a tree shows of itself: its nodes as arrays, and the way of a ray through them.

>>> import fastlines as fl
>>> tree = fl.build([[[0, 0, 0], [1, 1, 1]], [[8, 8, 8], [9, 9, 9]]], "bvh-cl", cost=fl.Cost(0.1))
>>> fl.inspection.outline_of(tree)
<Outline of custom: 3 nodes, 2 references>
>>> fl.inspection.trace_ray(tree, [0.5, 0.5, -5], [0, 0, 1], radius=0.1)
<Traversal: 1 inner node, 1 test, cost 1.1, 1 hit>
"""

from .outline import Outline as Outline
from .outline import outline_of as outline_of
from .traversal import Traversal as Traversal
from .traversal import trace_ray as trace_ray
