"""The controls of the page, in tabs beside the scene, and what each of them orders."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from ..errors import FastlinesError
from .choices import CLICKS, LINES, UNCUT, Choices
from .line_colors import color_names
from .pane import Pane
from .shot import make_ray, radius_text, read_radius, read_vector, vector_text
from .tables import STYLE, block, paragraph

#: The width of the panel in pixels.
WIDTH = 400.0
#: The radius slider spans so many powers of ten, and ends at this fraction of the size of the scene: up to there, the
#: way of a ray through 10⁵ segments is computed within 100 ms (`trace_ray` on spaghetti-2 takes 50 ms).
DECADES, LARGEST = 4.0, 0.01
#: What a ray may be asked for.
QUERIES = "all hits", "the first hit"


class Panel:
    """The controls, which change `choices` and order what depends on them.

    Parameters
    ----------
    gui : viser.GuiApi
    panes : sequence of Pane
    choices : Choices
    size : float
        The longest side of the scene.
    order : callable
        Takes what has changed, or what is to be done, as `Viewer` names it, and the browser that wants it.
    """

    def __init__(
        self, gui: Any, panes: list[Pane], choices: Choices, size: float, order: Callable[[str, Any], object]
    ) -> None:
        self._gui, self._panes, self.choices, self._order = gui, panes, choices, order
        self._largest = math.log10(LARGEST * size)
        self._changes = threading.Lock()
        gui.set_panel_label("fastlines")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(WIDTH)
        self.facts = gui.add_html(STYLE)
        self.caption = gui.add_html("")
        self._add_click()
        self.note = gui.add_html("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Lines"):
            self._add_lines()
        with tabs.add_tab("Tree"):
            self._add_tree()
        with tabs.add_tab("Ray"):
            self._add_ray()
        with tabs.add_tab("Save"):
            self._add_save()

    def say(self, text: str, kind: str = "note") -> None:
        """Say something, such as an error, above the tabs."""
        self.note.content = block(paragraph(text, kind)) if text else ""

    def _on(self, control: Any, kind: str, change: Callable[[Any], object]) -> Any:
        """Change the choices with a control, and order what depends on it; errors are said."""

        def changed(event: Any) -> None:
            if event.client_id is None:
                return  # this program has changed the control
            try:
                with self._changes:  # events come in several threads: the value is the latest one
                    change(event.target.value)
            except FastlinesError as error:
                self.say(str(error), "error")
                return
            self._order(kind, event.client)

        control.on_update(changed)
        return control

    def _set(self, name: str) -> Callable[[Any], None]:
        return lambda value: setattr(self.choices, name, value)

    def _add_click(self) -> None:
        click = self._gui.add_dropdown("A click", CLICKS, initial_value=self.choices.click)
        self._on(click, "nothing", self._set("click"))
        lines = self._gui.add_dropdown("Lines shown", LINES, initial_value=self.choices.lines)
        self._on(lines, "shown", self._set("lines"))
        if len(self._panes) > 1:
            names = [*(pane.name for pane in self._panes), "both, side by side"]
            sides = self._gui.add_dropdown("Tree shown", names, initial_value=names[self.choices.side])
            self._on(sides, "side", lambda value: setattr(self.choices, "side", names.index(value)))

    def _add_lines(self) -> None:
        gui, choices = self._gui, self.choices
        names = color_names(self._panes[0].tree.geometry)
        self._on(gui.add_dropdown("Colour by", names, initial_value=choices.color), "lines", self._set("color"))
        bright = gui.add_slider("Brightness", 0.0, 1.0, 0.05, choices.brightness)
        self._on(bright, "lines", self._set("brightness"))
        width = gui.add_slider("Width in pixels", 0.5, 6.0, 0.5, choices.width)
        self._on(width, "lines", self._set("width"))
        for axis in range(3):
            cut = gui.add_multi_slider(f"Cut {'xyz'[axis]}", 0.0, 1.0, 0.01, choices.cut[axis])
            self._on(cut, "lines", partial(self._cut, axis))
        self.lines = gui.add_html("")

    def _cut(self, axis: int, value: tuple[float, float]) -> None:
        cut = [*self.choices.cut]
        cut[axis] = min(value), max(value)
        self.choices.cut = UNCUT if tuple(cut) == UNCUT else tuple(cut)

    def _add_tree(self) -> None:
        gui, choices = self._gui, self.choices
        self._on(gui.add_checkbox("Boxes", choices.boxes), "level", self._set("boxes"))
        deepest = max(len(pane.outline.levels) for pane in self._panes) - 1
        self.level_slider = gui.add_slider("Level", 0, max(1, deepest), 1, choices.level)
        self._on(self.level_slider, "level", self._set("level"))
        self._on(gui.add_checkbox("Split planes", choices.planes), "level", self._set("planes"))
        self.level = gui.add_html("")
        most = max(pane.outline.n_nodes for pane in self._panes) - 1
        self.node = gui.add_number("Node", choices.node[1] if choices.node else 0, min=0, max=most, step=1)
        self._on(self.node, "path", self._pick)
        clear = gui.add_button("Clear the picked node")
        clear.on_click(lambda event: self._clear("node", "path", event.client))
        self.path = gui.add_html("")

    def _pick(self, node: int) -> None:
        shown = self.choices.side % len(self._panes)
        self._panes[shown].outline.path(int(node))  # refuses what is no node
        self.choices.node = shown, int(node)

    def _clear(self, name: str, kind: str, client: Any) -> None:
        setattr(self.choices, name, None)
        self._order(kind, client)

    def _add_ray(self) -> None:
        gui, choices = self._gui, self.choices
        takes = self._panes[0].tree.geometry.takes_radius
        self.radius = gui.add_text("Radius", radius_text(choices.radius), visible=takes)
        ends = round(self._largest - DECADES, 2), round(self._largest, 2)
        slid = self._log(choices.radius, *ends)
        hint = f"It ends at a hundredth of the scene, {10 ** ends[1]:.2g}; type a larger radius."
        self.radius_slider = gui.add_slider("Radius, log₁₀", *ends, 0.01, slid, visible=takes, hint=hint)
        self.query = gui.add_dropdown("Find", QUERIES, initial_value=QUERIES[choices.query == "first"])
        self.origin = gui.add_text("Origin", "")
        self.direction = gui.add_text("Direction", "")
        self._on(self.radius, "radius", self._type_radius)
        self._on(self.radius_slider, "radius", self._slide)
        self._on(self.query, "ray", lambda value: setattr(choices, "query", "first" if value == QUERIES[1] else "all"))
        shoot = gui.add_button("Shoot this ray")
        shoot.on_click(lambda event: self._shoot(event.client))
        self.step = gui.add_slider("Step", 0, 1, 1, 1)
        self._on(self.step, "step", self._set("step"))
        clear = gui.add_button("Clear the ray")
        clear.on_click(lambda event: self._clear("ray", "ray", event.client))
        self.way = gui.add_html("")

    def _slide(self, value: float) -> None:
        self.choices.radius = float(f"{10**value:.4g}")
        self.radius.value = radius_text(self.choices.radius)

    def _type_radius(self, text: str) -> None:
        self.choices.radius = read_radius(text)
        slider = self.radius_slider
        slider.value = self._log(self.choices.radius, slider.min, slider.max)

    def _log(self, radius: float, low: float, high: float) -> float:
        return low if radius <= 0 else round(min(max(math.log10(radius), low), high), 2)

    def show_ray(self) -> None:
        """Write the ray that is chosen into the controls."""
        choices, slider = self.choices, self.radius_slider
        if choices.ray is not None:
            self.origin.value, self.direction.value = map(vector_text, (choices.ray.origin, choices.ray.direction))
        self.radius.value = radius_text(choices.radius)
        slider.value = self._log(choices.radius, slider.min, slider.max)
        self.query.value = QUERIES[choices.query == "first"]

    def show_steps(self, n_steps: int) -> None:
        """Let the slider of steps end at some number, and put it there."""
        self.step.max = max(1, n_steps)
        self.step.value = self.choices.step = max(1, n_steps)

    def _shoot(self, client: Any) -> None:
        try:
            origin = read_vector(self.origin.value, "origin")
            direction = read_vector(self.direction.value, "direction")
            ray = make_ray(self._panes[0].tree, origin, direction, self.choices.radius)
        except FastlinesError as error:
            # The hits of another ray would be taken for those of this one.
            self._clear("ray", "ray", client)
            self.say(str(error), "error")
            return
        self.choices.ray = ray
        self._order("ray", client)

    def _add_save(self) -> None:
        gui = self._gui
        picture = gui.add_button("Screenshot (PNG)")
        picture.on_click(lambda event: self._order("screenshot", event.client))
        page = gui.add_button("This scene as a page (HTML)")
        page.on_click(lambda event: self._order("export", event.client))
        gui.add_html(
            block(paragraph("The page opens without a server. Both are saved where the browser saves files.", "note"))
        )
