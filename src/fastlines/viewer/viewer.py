"""A page in the browser, served from a background thread on the loopback address."""

from __future__ import annotations

import atexit
import contextlib
import os
import sys
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ..arrays import choice
from ..errors import FastlinesError, InputError
from ..inspection.traversal import QUERIES
from .choices import PICK, SHOOT, Choices
from .drawing import Drawing
from .export import page_html, write_page
from .latest import Latest
from .pane import Pane
from .panel import Panel
from .scene_frame import SceneFrame
from .screenshot import screenshot
from .server import HOST, start_server, stop_server
from .shot import make_ray
from .stage import Stage
from .tables import STYLE, block

#: How near to a line a click picks it, in pixels.
PICK_PIXELS = 4.0


class Viewer:
    """A page that shows a tree until it is closed; `view` makes it.

    Several browsers may show the page. They share what is chosen, and each has its own camera.

    Attributes
    ----------
    url : str
        The address of the page, whose last number is the `port`.
    choices : Choices
        What is chosen on the page.
    """

    def __init__(self, panes: list[Pane], choices: Choices, port: int | None) -> None:
        self.choices, self._panes = choices, panes
        frame = SceneFrame.around(panes[0].tree)
        self._server = start_server(port)
        self.port = int(self._server.get_port())
        self.url = f"http://{HOST}:{self.port}"
        self._is_open = True
        atexit.register(self.close)  # before viser's own, which is not silent
        self._worker = Latest(self._failed)
        try:
            self._drawing = Drawing(Stage(self._server, frame), panes, choices)
            self._panel = Panel(self._server.gui, panes, choices, frame.size, self._order)
            self._panel.facts.content = STYLE + block(self._drawing.facts())
            self._server.scene.on_click()(self._clicked)
            self._redraw_all()
        except BaseException:
            self.close()
            raise

    def __repr__(self) -> str:
        return (
            f"<Viewer of {' and '.join(pane.name for pane in self._panes)}: {self.url if self._is_open else 'closed'}>"
        )

    def _repr_html_(self) -> str:
        if not self._is_open:
            return "<p>This viewer is closed.</p>"
        return f'<iframe src="{self.url}" width="100%" height="640" style="border:0" title="fastlines"></iframe>'

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the server; a closed viewer stays closed."""
        if self._is_open:
            self._is_open = False
            atexit.unregister(self.close)
            self._worker.close()
            stop_server(self._server)

    def wait(self) -> None:
        """Wait until everything that has been chosen is drawn."""
        self._check_open()
        self._worker.wait()

    def _check_open(self) -> None:
        if not self._is_open:
            raise InputError("this viewer is closed; fl.view makes another one")

    def shoot(
        self,
        origin: npt.ArrayLike,
        direction: npt.ArrayLike,
        radius: float | None = None,
        *,
        query: Literal["all", "first"] | None = None,
    ) -> None:
        """Shoot a ray, as a click does.

        Parameters
        ----------
        origin, direction : (3,) arrays
            In the coordinates of `Tree.all_hits`.
        radius : float, optional
        query : {"all", "first"}, optional
            What is not given stays as it is on the page.

        Raises
        ------
        InputError
            If the ray cannot be asked.
        """
        self._check_open()
        choices = self.choices
        query = choices.query if query is None else query
        choice("query", query, QUERIES)
        radius = choices.radius if radius is None else radius
        ray = make_ray(self._panes[0].tree, origin, direction, radius)
        choices.ray, choices.radius, choices.query = ray, float(radius), query
        self._order("ray", None)

    def pick(self, node: int | None) -> None:
        """Show the path from the root to a node of the first tree, and its references; None shows none.

        Raises
        ------
        InputError
            If there is no such node.
        """
        self._check_open()
        if node is not None:
            node = int(self._panes[0].outline.path(node)[-1])
        self.choices.node = None if node is None else (0, node)
        self._order("path", None)

    def export(self, path: str | os.PathLike[str]) -> None:
        """Write what is shown as one HTML file, which opens without a server.

        Raises
        ------
        InputError
            If the file cannot be one, because of its ending or its place.
        OSError
            If it cannot be written.
        """
        if self._is_open:
            self.wait()
        write_page(path, self._panes, self.choices)

    # --- What the page orders ---

    def _order(self, kind: str, client: Any) -> None:
        """Carry out what a control or a click wants, in the thread of the worker."""
        work = {
            "lines": self._draw_lines,
            "level": self._draw_level,
            "path": self._draw_path,
            "ray": self._shoot,
            "radius": self._follow,
            "step": self._draw_way,
            "shown": self._draw_shown,
            "side": self._redraw_all,
            "screenshot": lambda: self._screenshot(client),
            "export": lambda: self._export(client),
        }.get(kind)
        self._panel.say("")
        if work is not None:
            self._worker.order(kind, work)

    def _redraw_all(self) -> None:
        self._drawing.arrange()
        self._draw_lines()
        self._draw_level()
        self._draw_path()
        self._shoot()

    def _draw_lines(self) -> None:
        caption, legend = self._drawing.lines()
        self._panel.caption.content, self._panel.lines.content = block(caption), block(legend)

    def _draw_level(self) -> None:
        self._panel.level.content = block(self._drawing.level())

    def _draw_path(self) -> None:
        node = self.choices.node
        if node is not None:
            self._panel.node.value = node[1]
        self._panel.path.content = block(self._drawing.path())

    def _shoot(self) -> None:
        self._panel.show_ray()
        self._follow()

    def _follow(self) -> None:
        had_way = self._drawing.has_way
        try:
            self._panel.show_steps(self._drawing.shoot())
        except FastlinesError:
            self._draw_way()  # without the way of another radius
            raise
        if had_way != self._drawing.has_way:
            # Lines and boxes give way to the ray, and come back without it.
            self._draw_lines()
            self._draw_level()
        self._draw_way()

    def _draw_shown(self) -> None:
        self._draw_lines()
        self._draw_way()

    def _draw_way(self) -> None:
        self._panel.way.content = block(self._drawing.way())

    def _clicked(self, event: Any) -> None:
        """Shoot or pick where somebody has clicked."""
        choices, camera = self.choices, event.client.camera
        if choices.click == SHOOT:
            choices.ray = self._drawing.ray_of_click(event.ray_origin, event.ray_direction)[1]
            self._order("ray", event.client)
        elif choices.click == PICK:
            away = float(np.sqrt(((camera.position - camera.look_at) ** 2).sum()))
            width = PICK_PIXELS * 2 * away * float(np.tan(camera.fov / 2)) / max(1, camera.image_height)
            self._panel.say("")
            self._worker.order("path", lambda: self._pick(event.ray_origin, event.ray_direction, width))

    def _pick(self, place: Any, direction: Any, width: float) -> None:
        self.choices.node = self._drawing.pick(place, direction, width)
        self._draw_path()

    def _screenshot(self, client: Any) -> None:
        picture = screenshot(client, self._drawing.legend)
        client.send_file_download("fastlines.png", picture, save_immediately=True)

    def _export(self, client: Any) -> None:
        page = page_html(self._panes, self.choices)
        client.send_file_download("fastlines.html", page.encode(), save_immediately=True)
        self._panel.say(f"The page has {len(page) / 1e6:.1f} MB.")

    def _failed(self, error: Exception) -> None:
        """Say an error on the page; one that is not of the user's making also on stderr."""
        if not self._is_open:
            return
        is_known = isinstance(error, FastlinesError | MemoryError)
        text = str(error) if is_known else f"{type(error).__name__}: {error}"
        if _is_gone(error):
            text = "the browser that asked for a picture has gone away, or takes too long"
        with contextlib.suppress(Exception):  # whoever asked may be gone
            self._panel.say(text, "error")
        if not is_known and not _is_gone(error):
            print(f"error in the viewer: {text}", file=sys.stderr, flush=True)


def _is_gone(error: Exception) -> bool:
    """Return whether a browser has gone away, or does not answer."""
    return isinstance(error, TimeoutError) or "disconnected" in str(error)
