"""Pictures of trees, drawn on axes of matplotlib: for trees of the core and of `fastlines.theory` alike.

Each function takes a tree and returns the axes that it drew on, new ones unless ``ax`` is given.

>>> import fastlines as fl
>>> tree = fl.build(fl.scenes.make("spaghetti", 200).lines, "bvh-d2")
>>> fl.drawing.draw_levels(tree, 3).get_title()
'bvh-d2, level 3: 8 boxes'
"""

from .graph import draw_graph as draw_graph
from .histograms import draw_depths as draw_depths
from .histograms import draw_leaf_sizes as draw_leaf_sizes
from .icicle import draw_icicle as draw_icicle
from .levels import draw_levels as draw_levels
from .partition import draw_partition as draw_partition
from .planes import draw_planes as draw_planes
from .ray import draw_ray as draw_ray
from .sheet import draw_level_sheet as draw_level_sheet
from .sheet import draw_sheet as draw_sheet
from .work import draw_work as draw_work
