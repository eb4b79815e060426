"""What is on the page: one or two trees, drawn as it is chosen, and what the page says about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..camera import Camera
from ..errors import InputError
from ..geometry.hit_places import Float64Array
from ..inspection.outline import Outline
from ..inspection.slabs import enter
from ..inspection.traversal import trace_ray
from ..rendering.default_view import default_view
from ..structure.tree_data import TreeData
from .choices import Choices
from .line_colors import LineLegend
from .node_path import path_table, references_text
from .pane import Pane
from .shot import Ray, hit_table, hits_text, rounded, step_text, work_table
from .stage import Stage
from .tables import Table, heading, legend_html, paragraph

#: The gap between trees beside each other, as a fraction of the size of one.
GAP = 0.15
#: The aspect ratio of the part of the page that is not the panel.
ASPECT = 1.1
#: How much farther away the camera is than the lines need, so that boxes around them are seen.
BACK = 1.1


class Drawing:
    """Trees on a stage.

    Parameters
    ----------
    stage : Stage
    panes : sequence of Pane
        One tree, or two over the same lines.
    choices : Choices
    """

    def __init__(self, stage: Stage, panes: Sequence[Pane], choices: Choices) -> None:
        self.stage, self.panes, self.choices = stage, panes, choices
        self.legend: LineLegend | None = None
        self._along, self._view = _axes_of_view(panes[0])

    @property
    def shown(self) -> list[Pane]:
        """The trees that are shown."""
        return list(self.panes) if self.choices.side == len(self.panes) > 1 else [self.panes[self.choices.side]]

    def arrange(self) -> None:
        """Put the trees that are shown beside each other, and choose the camera that frames them."""
        for pane in self.panes:
            self.stage.hide(pane.group)
        for pane, place in self._places():
            self.stage.place(pane.group, place)
            if len(self.shown) > 1:
                self.stage.label(f"{pane.group}/name", pane.name, self._top())
        camera = Camera.framing(self._outermost(), *self._view, aspect=ASPECT)
        x, y, z = (camera.target + BACK * np.subtract(camera.origin, camera.target)).tolist()
        self.stage.look(replace(camera, origin=(x, y, z)))

    def _outermost(self) -> Float64Array:
        """Return points of the page that are to be in the first view: those of lines, or of the box without any."""
        frame = self.stage.frame
        ends = self.panes[0].strokes(self.stage, self.choices).ends.reshape(-1, 3)
        points = frame.to_page(ends if len(ends) else frame.box)
        return np.concatenate([points + place for _, place in self._places()])

    def _top(self) -> Float64Array:
        """Return the middle of the side of the box of everything that is upwards in the first view."""
        box, up = self.stage.frame.box, np.array(self._view[1])
        return np.asarray(box.mean(axis=0) + 0.5 * up * (box[1] - box[0]))

    def _places(self) -> list[tuple[Pane, Float64Array]]:
        """Return where on the page the trees are that are shown."""
        frame, shown = self.stage.frame, self.shown
        step = (1 + GAP) * frame.scale * float(np.abs(self._along) @ (frame.box[1] - frame.box[0]))
        return [(pane, self._along * step * (i - (len(shown) - 1) / 2)) for i, pane in enumerate(shown)]

    def facts(self) -> str:
        """Return what is known of the trees, as HTML."""
        columns = [tree_facts(pane.tree, pane.outline) for pane in self.panes]
        rows = [[name, *(column[name] for column in columns)] for name in columns[0]]
        return Table(["tree", *(pane.name for pane in self.panes)], rows).html()

    def lines(self) -> tuple[str, str]:
        """Draw the lines; return how many are shown, and what their colours mean, as HTML."""
        with self.stage.atomic():
            said = [pane.draw_lines(self.stage, self.choices) for pane in self.shown]
        self.legend = said[0][1]
        parts = []
        for pane, (_, legend) in zip(self.shown, said, strict=True):
            of_tree = len(said) > 1 and said[0][1].title == legend.title and legend.bar is not None
            parts.append((paragraph(pane.name, "note") if of_tree else "") + legend_html(legend))
        return paragraph(said[0][0]), "".join(dict.fromkeys(parts))

    def level(self) -> str:
        """Draw the boxes and planes of the level; return what is shown, as HTML."""
        with self.stage.atomic():
            said = [(pane, pane.draw_level(self.stage, self.choices)) for pane in self.shown]
        return "".join(paragraph(f"{pane.name}, {text}") for pane, texts in said for text in texts)

    def path(self) -> str:
        """Draw the path to the picked node; return a table of it, as HTML."""
        chosen = self.choices.node
        with self.stage.atomic():
            for pane in self.shown:
                pane.draw_path(self.stage, self.choices, self.panes.index(pane))
        if chosen is None:
            return ""
        pane = self.panes[chosen[0]]
        about = f"{pane.name}, {references_text(pane.outline, chosen[1])}"
        return heading(about) + path_table(pane.outline, chosen[1]).html()

    def shoot(self) -> int:
        """Follow the ray through all trees; return the most nodes that one of those shown visits."""
        for pane in self.panes:
            pane.way = None
        for pane in self.panes:
            pane.shoot(self.choices)
        return max((len(pane.way.nodes) for pane in self.shown if pane.way is not None), default=0)

    @property
    def has_way(self) -> bool:
        """Whether a ray has been shot."""
        return self.panes[0].way is not None

    def way(self) -> str:
        """Draw the ray and its way; return what it costs and what it hits, as HTML."""
        with self.stage.atomic():
            captions = {pane.name: pane.draw_way(self.stage, self.choices) for pane in self.shown}
        self.stage.flush()
        ways = [(pane, pane.way) for pane in self.panes if pane.way is not None]
        if not ways:
            return ""
        names, traced = [pane.name for pane, _ in ways], [way for _, way in ways]
        steps = [
            paragraph(
                "; ".join([f"{pane.name}, {step_text(way, pane.outline, self.choices.step)}", *captions[pane.name]])
            )
            for pane, way in ways
            if pane in self.shown
        ]
        hits = traced[0].hits
        found = heading(hits_text(hits)) + (hit_table(hits).html() if len(hits) else "")
        work = work_table(names, traced, [pane.outline for pane, _ in ways]).html()
        turn = paragraph("turn the view to see the ray from its side", "note")
        return heading("The ray in each tree") + work + "".join(steps) + turn + found

    def ray_of_click(self, place: Sequence[float], direction: Sequence[float]) -> tuple[int, Ray]:
        """Return the tree, and the ray in its coordinates, of a ray of the page that somebody has clicked."""
        frame = self.stage.frame
        box, along = frame.to_page(frame.box), np.asarray(direction, np.float64)
        origins = [(pane, np.asarray(place, np.float64) - at) for pane, at in self._places()]
        nearest = min(origins, key=lambda each: float(enter(box[None], each[1][None], along, 0.0)[0]))
        ray = Ray(rounded(frame.to_given(nearest[1]), frame.size), rounded(along, 1.0))
        return self.panes.index(nearest[0]), ray

    def pick(self, place: Sequence[float], direction: Sequence[float], width: float) -> tuple[int, int]:
        """Return the tree and the leaf of the first line near a ray of the page, at most `width` away from it.

        Raises
        ------
        InputError
            If there is none.
        """
        index, ray = self.ray_of_click(place, direction)
        pane = self.panes[index]
        radius = width / self.stage.frame.scale if pane.tree.geometry.takes_radius else 0.0
        way = trace_ray(pane.tree, ray.origin, ray.direction, radius, query="first", outline=pane.outline)
        found = way.nodes[way.n_found > 0]
        if not len(found):
            raise InputError("no line is near that place; click nearer to one, or enter the number of a node")
        return index, int(found[-1])


def tree_facts(tree: TreeData, outline: Outline) -> dict[str, str]:
    """Return figures of a tree that fit beside those of another; its cost is by the model of the outline.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.inspection import outline_of
    >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]], "kd-d2")
    >>> tree_facts(tree, outline_of(tree))["cost, c_trav 0.6"]
    '1'
    """
    stats, model = tree.stats(), outline.model
    name = f"cost, c_trav {model.c_trav:g}" + (f", c_prim {model.c_prim:g}" if model.c_prim != 1 else "")
    per_prim = f", {stats['refs_per_prim']:.3g} a primitive" if stats["n_refs"] != stats["n_prims"] else ""
    return {
        "nodes, levels": f"{stats['n_nodes']:,}, {stats['depth'] + 1}",
        "references": f"{stats['n_refs']:,}{per_prim}",
        "in a leaf": f"{stats['mean_leaf_refs']:.3g}, {stats['largest_leaf_refs']:,} at most",
        name: f"{outline.cost_below[0]:,.6g}",
    }


def _axes_of_view(pane: Pane) -> tuple[Float64Array, tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Return the axis that points most to the right in the first view, and the directions of this view."""
    direction, up = default_view(pane.tree.geometry)
    right = np.cross(direction, up)
    along = np.zeros(3)
    axis = int(np.abs(right).argmax())
    along[axis] = np.sign(right[axis])
    return along, (direction, up)
