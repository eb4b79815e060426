"""One of the trees on the page, and how it is drawn there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import InputError
from ..inspection.outline import Outline, outline_of
from ..inspection.traversal import Traversal, trace_ray
from ..rendering.color.palette import hexadecimal, mapped
from ..settings.settings import Cost
from ..support.distinct import distinct
from ..tree import Tree
from .choices import ALL, NONE, TESTED, Choices
from .line_colors import LineLegend, line_colors
from .node_boxes import box_edges, level_boxes, split_planes
from .node_path import MAX_REFS, reference_strokes
from .shot import MAX_HITS, MAX_POINTS, MAX_VISITED, ray_ends
from .stage import Stage
from .strokes import Strokes, strokes_of, strokes_of_prims
from .thinning import MAX_SHOWN

#: Colours, linear: of references of the picked node, of its path, of the ray, of hits, and of the node of a step.
REFS, PATH, RAY, HIT, NOW = map(hexadecimal, ("#ffd54a", "#ffffff", "#ff5a5a", "#ff9d2e", "#ffffff"))
#: The colour of references that the ray tests, and the brightness of the boxes of the level behind its way.
TEST, BEHIND = hexadecimal("#5f86b8"), 0.3
#: The colour of split planes, as sRGB, and how much they hide.
PLANE, OPACITY = (80, 150, 255), 0.16
#: Widths in pixels: of boxes of inner nodes and of leaves, of what is picked, and of the ray.
THIN, THICK, PICKED, WAY = 1.2, 2.6, 2.5, 3.0
#: The colour map of the order in which nodes are visited, and the most labels of them.
ORDER, MAX_LABELS = "viridis", 12


@dataclass(eq=False)
class Pane:
    """A tree on the page.

    Attributes
    ----------
    tree : Tree
    name : str
        What the page calls it.
    group : str
        The group of its names on the stage.
    model : Cost
        The costs of a step and of a test.
    most : int
        About the most strokes that draw its lines.
    way : Traversal or None
        The way of the ray that was shot last.
    """

    tree: Tree
    name: str
    group: str
    model: Cost
    most: int = MAX_SHOWN
    way: Traversal | None = None
    outline: Outline = field(init=False, repr=False)
    _drawn: tuple[object, Strokes] | None = field(init=False, default=None, repr=False)

    def __post_init__(self) -> None:
        self.outline = outline_of(self.tree, self.model)

    def shoot(self, choices: Choices) -> None:
        """Follow the ray that is chosen through the tree.

        Raises
        ------
        InputError
            If it cannot be asked, or hits more than the page can follow.
        """
        ray = choices.ray
        if ray is None:
            self.way = None
            return
        asked = ray.origin, ray.direction, choices.radius
        n_hits = int(self.tree.count_hits(*asked))
        if n_hits > MAX_HITS:
            raise InputError(
                f"the ray hits {n_hits:,} primitives; the page follows at most {MAX_HITS:,}: lower the radius"
            )
        self.way = trace_ray(self.tree, *asked, query=choices.query, outline=self.outline)

    def strokes(self, stage: Stage, choices: Choices) -> Strokes:
        """Return the strokes that draw the lines between the cut planes."""
        key = (self.most, choices.cut)
        if self._drawn is None or self._drawn[0] != key:
            self._drawn = key, strokes_of(self.tree.geometry, self.most, choices.slab(stage.frame))
        return self._drawn[1]

    def draw_lines(self, stage: Stage, choices: Choices) -> tuple[str, LineLegend]:
        """Draw the lines; return how many are shown, and what their colours mean."""
        strokes = self.strokes(stage, choices)
        colors, legend = line_colors(choices.color, strokes, self.tree.geometry, self.outline)
        shown = len(strokes.ends) if choices.lines == ALL or self.way is None else 0
        bright = choices.brightness if self.way is None else BEHIND * choices.brightness
        ends, light = strokes.ends[:shown], bright * colors[:shown]
        stage.strokes(f"{self.group}/lines", ends, light, choices.width)
        return strokes.caption, legend

    def draw_level(self, stage: Stage, choices: Choices) -> list[str]:
        """Draw the boxes and the split planes of a level; return what is shown."""
        captions = []
        boxes, colors = np.empty((0, 2, 3)), np.empty((0, 3), np.float32)
        if choices.boxes:
            shown = level_boxes(self.outline, choices.level)
            boxes, colors = self.outline.boxes[shown.nodes], shown.colors
            captions.append(shown.caption)
        few = len(boxes) <= 64
        bright = 1.0 if self.way is None else BEHIND
        stage.strokes(
            f"{self.group}/level", box_edges(boxes), np.repeat(bright * colors, 12, axis=0), 2.0 if few else THIN
        )
        quads = np.empty((0, 4, 3))
        if choices.planes:
            quads, text = split_planes(self.outline, choices.level)
            captions.append(text)
        stage.faces(f"{self.group}/planes", quads, PLANE, OPACITY)
        sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2, 3)
        stage.strokes(f"{self.group}/rims", sides, np.array(PLANE) / 255, THIN)
        return captions

    def draw_path(self, stage: Stage, choices: Choices, index: int) -> None:
        """Draw the boxes from the root to the picked node, and its references."""
        node = choices.node[1] if choices.node is not None and choices.node[0] == index else None
        path = np.empty(0, np.int64) if node is None else self.outline.path(node)
        refs = np.empty((0, 2, 3)) if node is None else reference_strokes(self.tree.geometry, self.outline, [node])
        faint = np.linspace(0.15, 1.0, max(1, len(path)))[:, None] * PATH
        edges = box_edges(self.outline.boxes[path])
        stage.strokes(f"{self.group}/path", edges, np.repeat(faint[: len(path)], 12, axis=0), THICK)
        stage.strokes(f"{self.group}/refs", refs, REFS, PICKED)

    def draw_way(self, stage: Stage, choices: Choices) -> list[str]:
        """Draw the ray, the boxes that it enters up to a step, and its hits; return what is left out."""
        way, ray, group = self.way, choices.ray, f"{self.group}/way"
        if way is None or ray is None:
            stage.hide(group)
            return []
        offset = stage.frame.offset
        grown = stage.frame.box + offset + np.array([[-choices.radius], [choices.radius]])
        stops = choices.query == "first" and len(way.hits) > 0
        ends = ray_ends(ray, grown, float(way.hits.t[-1]) if stops else None)
        stage.strokes(f"{group}/ray", np.empty((0, 2, 3)) if ends is None else ends[None] - offset, RAY, WAY)
        points = way.hits.points()[:MAX_POINTS] - offset
        stage.points(f"{group}/hits", points, HIT)
        geometry = self.tree.geometry
        prims = distinct(geometry.number(way.hits.part, way.hits.prim))
        hit = strokes_of_prims(geometry, prims[:MAX_POINTS]) if choices.lines != NONE else np.empty((0, 2, 3))
        stage.strokes(f"{group}/hit", hit, HIT, PICKED)
        leaves = way.nodes[way.is_leaf] if choices.lines == TESTED else way.nodes[:0]
        stage.strokes(f"{group}/tested", reference_strokes(geometry, self.outline, leaves), TEST, choices.width)
        n_boxes = self._draw_visited(stage, way, choices.step, group)
        n_tested = int(self.outline.n_refs[leaves].sum())
        return [
            *left_out("the last", MAX_VISITED, n_boxes, "boxes"),
            *left_out("the first", MAX_POINTS, len(way.hits), "hits"),
            *(left_out("the first", MAX_POINTS, len(prims), "lines hit") if choices.lines != NONE else ()),
            *left_out("evenly spaced", MAX_REFS, n_tested, "references tested"),
        ]

    def _draw_visited(self, stage: Stage, way: Traversal, step: int, group: str) -> int:
        """Draw the boxes of visited nodes by their order, leaves thick, the one of the step white; return how many."""
        n = min(step, len(way.nodes))
        first = max(0, n - MAX_VISITED)
        nodes, leaf = way.nodes[first:n], way.is_leaf[first:n]
        order = np.arange(first, n) / max(1, len(way.nodes) - 1)
        colors = mapped(order, ORDER)
        for name, some, width in (("inner", ~leaf, THIN), ("leaves", leaf, THICK)):
            edges = box_edges(self.outline.boxes[nodes[some]])
            stage.strokes(f"{group}/{name}", edges, np.repeat(colors[some], 12, axis=0), width)
        now = nodes[-1:] if n < len(way.nodes) else nodes[:0]
        stage.strokes(f"{group}/now", box_edges(self.outline.boxes[now]), NOW, PICKED + 1)
        stage.hide(f"{group}/number")
        if len(now):
            stage.label(f"{group}/number", str(n), self.outline.boxes[int(now[0]), 1])
        return n


def left_out(which: str, most: int, n: int, noun: str) -> list[str]:
    """Return a text that says how many of something are shown, if not all are.

    Examples
    --------
    >>> left_out("the last", 2000, 286175, "boxes"), left_out("the last", 2000, 7, "boxes")
    (['the last 2,000 of 286,175 boxes are shown'], [])
    """
    return [f"{which} {most:,} of {n:,} {noun} are shown"] if n > most else []
