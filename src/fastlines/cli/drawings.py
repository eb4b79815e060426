"""What ``fastlines draw`` does: it checks the options, opens the lines, builds trees, and writes a drawing of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .. import drawing
from ..arrays import choice, did_you_mean
from ..builder import build
from ..drawing.axes import library, light, new_figure, share_scale, share_width
from ..drawing.files import check_drawing_path, write_drawing
from ..drawing.letters import MAX_NODES
from ..errors import InputError
from ..inspection.outline import outline_of
from ..settings.methods import method_settings
from ..structure.tree_data import TreeData
from .files import check_output, open_lines, show_progress
from .options import refuse_given

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The kinds whose nodes have letters.
LETTERED = ("partition", "graph", "thesis")
#: How wide panels that are side by side are together at most, in inches.
WIDTH = 15.0


@dataclass(frozen=True)
class Kind:
    """A kind of drawing.

    Attributes
    ----------
    draw : tuple of callable
        What draws one tree, a panel each.
    width, height : float
        Of a panel, in inches.
    level : str
        The parameter that --level is; empty if it does not apply.
    has_axis : bool
        Whether --axis applies.
    by : tuple of str
        What --by can be; the first is the default.
    is_joint : bool
        Whether all trees are drawn on the same axes.
    more : tuple of str
        What else is passed: the "model" of the first tree's costs, and whether "progress" is shown.
    """

    draw: tuple[Callable[..., Any], ...] = ()
    width: float = 5.0
    height: float = 5.6
    level: str = ""
    has_axis: bool = False
    by: tuple[str, ...] = ()
    is_joint: bool = False
    more: tuple[str, ...] = ()


PARTITION, GRAPH = drawing.draw_partition, drawing.draw_graph
KINDS = {
    "sheet": Kind(has_axis=True),
    "levels": Kind((drawing.draw_levels,), level="level", has_axis=True),
    "planes": Kind((drawing.draw_planes,), level="max_level", has_axis=True),
    "icicle": Kind((drawing.draw_icicle,), 8.0, 4.0, by=("cost", "refs"), more=("model",)),
    "leaves": Kind((drawing.draw_leaf_sizes,), 6.0, 3.6, by=("number", "share", "chance"), is_joint=True),
    "depths": Kind((drawing.draw_depths,), 6.0, 3.6, by=("number", "share", "chance"), is_joint=True),
    "work": Kind((drawing.draw_work,), 5.6, 4.8, by=("nodes", "cost"), more=("model", "progress")),
    "partition": Kind((PARTITION,), level="max_level", has_axis=True),
    "graph": Kind((GRAPH,), 5.0, 4.0, level="max_level"),
    "thesis": Kind((PARTITION, GRAPH), 5.0, 4.3, level="max_level"),
}


@dataclass(frozen=True, kw_only=True)
class Order:
    """The options of ``fastlines draw``; `methods` are those of the first tree, if it is given, and of the others."""

    source: str
    output: str
    kind: str
    methods: list[str | None]
    level: int | None
    axis: Any
    by: str | None
    skip_invalid: bool
    format: str | None
    option: list[str] | None

    def __post_init__(self) -> None:
        """Check the options as far as that can be done without the lines."""
        check_drawing_path(self.output)
        check_output(self.output, inputs=[self.source])
        if self.kind not in KINDS:
            raise InputError(f"there is no kind of drawing {self.kind!r}{did_you_mean(self.kind, KINDS)}")
        how = KINDS[self.kind]
        unused = {
            "--level": None if how.level else self.level,
            "--axis": None if how.has_axis else self.axis,
            "--by": None if how.by else self.by,
        }
        refuse_given(unused, f"--kind is {self.kind}")
        if self.axis is not None:
            choice("--axis", self.axis, ("x", "y", "z"))
        if self.by is not None:
            choice("--by", self.by, how.by)
        for method in self.methods:
            if method is not None:
                method_settings(method)
        if self.kind == "levels" and self.level is None and len(self.methods) > 1:
            raise InputError("--kind levels draws six levels of one tree; add --level to draw one level of several")
        library()

    @property
    def how(self) -> Kind:
        """The kind of drawing."""
        return KINDS[self.kind]

    @property
    def given(self) -> dict[str, Any]:
        """The arguments of what draws."""
        options = {self.how.level: self.level, "axis": self.axis, "by": self.by}
        return {name: value for name, value in options.items() if name and value is not None}


def write(order: Order) -> str:
    """Write the drawing of an order; return what was written, in words."""
    opened = open_lines(order.source, order.skip_invalid, order.format, order.option)
    trees, methods = dict[str, TreeData](), order.methods
    if isinstance(opened.tree, TreeData):
        first, *methods = order.methods
        refuse_given({"--method": first}, f"{order.source} is a tree already; --against draws others beside it")
        trees[opened.tree.method] = opened.tree
    for method in methods:
        if (method or "best") in trees:
            raise InputError(f"{method} is drawn already; name other trees with --against")
        tree = build(opened.geometry, method, progress=show_progress())
        trees[tree.method] = tree
    write_drawing(order.output, figure_of(order, opened.name, trees))
    return f"{order.output}: {order.kind} of {', '.join(trees)} over {opened.geometry.count_text()}"


def figure_of(order: Order, name: str, trees: Mapping[str, TreeData]) -> Figure:
    """Return the figure of an order."""
    how, given = order.how, order.given
    if order.kind == "sheet":
        return drawing.draw_sheet(trees, title=name, axis=order.axis, progress=show_progress())
    if order.kind == "levels" and order.level is None:
        return drawing.draw_level_sheet(next(iter(trees.values())), axis=order.axis)
    if order.level is not None:
        _check_level(order, trees)
    if how.is_joint:
        figure = new_figure(how.width, how.height)
        with light():
            how.draw[0](trees, **given, ax=figure.subplots())
        return figure
    return _beside(order, trees)


def _check_level(order: Order, trees: Mapping[str, TreeData]) -> None:
    """Refuse a level that a tree does not have, or whose boxes are too many for letters."""
    for method, tree in trees.items():
        outline = outline_of(tree)
        if order.kind == "levels" and order.level is not None and order.level >= len(outline.levels):
            raise InputError(f"--level {order.level}: {method} has levels 0 to {len(outline.levels) - 1} here")
        if order.kind in LETTERED and order.level is not None:
            n_nodes = sum(len(nodes) for nodes in outline.levels[: order.level + 1])
            if n_nodes > MAX_NODES:
                raise InputError(
                    f"--level {order.level}: {method} has {n_nodes:,} nodes up to there, and --kind {order.kind} draws "
                    f"at most {MAX_NODES}; give a smaller one, or --kind levels"
                )


def _beside(order: Order, trees: Mapping[str, TreeData]) -> Figure:
    """Draw trees side by side. Images and icicles have one scale, and costs are those of the first tree's model."""
    how = order.how
    first = next(iter(trees.values()))
    known = {"model": first.settings.cost, "progress": show_progress()}
    given = order.given | {name: known[name] for name in how.more}
    columns = len(how.draw) if len(how.draw) > 1 else min(len(trees), int(WIDTH / how.width))
    rows = -(-len(trees) * len(how.draw) // columns)
    figure = new_figure(how.width * columns, how.height * rows)
    with light():
        panels = [figure.add_subplot(rows, columns, i + 1) for i in range(len(trees) * len(how.draw))]
    draws = [(draw, tree) for tree in trees.values() for draw in how.draw]
    for panel, (draw, tree) in zip(panels, draws, strict=True):
        draw(tree, **given, ax=panel)
    share_scale(panels)
    if order.kind == "icicle":
        share_width(panels)
    return figure
