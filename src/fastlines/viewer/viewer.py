"""``fl.view``: a tree in the browser, served from a background thread on the loopback address."""

from __future__ import annotations

import atexit
import contextlib
import io
import os
import sys
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ..arrays import choice, count, number
from ..builder import build
from ..errors import FastlinesError, InputError
from ..inspection.traversal import QUERIES
from ..theory.node import Node
from ..tree import Tree
from .choices import PICK, SHOOT, Choices
from .drawing import Drawing
from .export import page_html, write_page
from .latest import Latest
from .line_colors import check_color
from .pane import Pane
from .panel import Panel
from .scene_frame import SceneFrame
from .server import HOST, start_server, stop_server, viser
from .shot import Ray
from .stage import Stage
from .tables import STYLE, block

#: The radius of rays through lines that have none of their own, as a fraction of the longest side of the scene.
SMALL = 0.002
#: How near to a line a click picks it, in pixels.
PICK_PIXELS = 4.0
#: The longest side of a screenshot in pixels, and how long a browser may take for it, in seconds.
LONGEST, PATIENCE = 2048, 60.0
#: The level that is shown first is the last one before there are more nodes than this.
FEW_BOXES = 16
#: The colour behind the scene.
BACKGROUND = (20, 20, 20)


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
        self._worker.wait()

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
        self.choices.ray = make_ray(
            self._panes[0].tree, origin, direction, self.choices.radius if radius is None else radius
        )
        if radius is not None:
            self.choices.radius = float(radius)
        if query is not None:
            choice("query", query, QUERIES)
            self.choices.query = query
        self._order("ray", None)

    def pick(self, node: int | None) -> None:
        """Show the path from the root to a node of the first tree, and its references; None shows none.

        Raises
        ------
        InputError
            If there is no such node.
        """
        if node is not None:
            self._panes[0].outline.path(node)
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
        self._panel.show_steps(self._drawing.shoot())
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
        from PIL import Image

        camera = client.camera
        shrink = min(1.0, LONGEST / max(camera.image_width, camera.image_height, 1))
        size = round(camera.image_height * shrink), round(camera.image_width * shrink)
        pixels = client.get_render(*size, transport_format="png", timeout=PATIENCE)
        image = Image.new("RGBA", pixels.shape[1::-1], (*BACKGROUND, 255))
        image.alpha_composite(Image.fromarray(pixels))
        stream = io.BytesIO()
        image.convert("RGB").save(stream, "PNG")
        client.send_file_download("fastlines.png", stream.getvalue(), save_immediately=True)

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


def make_ray(tree: Tree, origin: npt.ArrayLike, direction: npt.ArrayLike, radius: float) -> Ray:
    """Check a ray by asking it, and return it.

    Raises
    ------
    InputError
        If `Tree.all_hits` refuses it.
    """
    given = [np.asarray(values) for values in (origin, direction)]
    if any(values.shape != (3,) for values in given):
        raise InputError(f"origin={origin!r}, direction={direction!r}; expected three numbers each")
    tree.any_hit(given[0], given[1], radius)
    (x, y, z), (dx, dy, dz) = (values.astype(np.float64).tolist() for values in given)
    return Ray((x, y, z), (dx, dy, dz))


def view(
    tree: Tree,
    *,
    against: Tree | str | None = None,
    color: str | None = None,
    level: int | None = None,
    radius: float | None = None,
    port: int | None = None,
) -> Viewer:
    """Show a tree in the browser: its lines, its boxes, and the way of a ray through it.

    The page is served on the loopback address only, by a thread, until `Viewer.close` or the end of the program. It
    needs the extra ``fastlines[view]``. In a notebook, the viewer shows itself.

    Parameters
    ----------
    tree : Tree
    against : Tree or str, optional
        A second tree over the same lines, or the method to build it by. A ray is shot into both.
    color : str, optional
        What colours of lines depend on: "direction", "strand", "depth", "leaf size", "cost", "radius", or an attribute.
    level : int, optional
        The level whose boxes are shown; by default one with a few of them.
    radius : float, optional
        How near to a ray lines are hit, until the page changes it; by default a little for lines without a radius of
        their own, and else 0.
    port : int, optional
        By default the first free one from 8080 on; 0 takes any.

    Raises
    ------
    InputError
        If the tree has no primitives, the second one is over others, there is no such colour or level, or the port is
        in use.
    MissingExtraError
        If viser is not installed.

    Examples
    --------
    >>> import fastlines as fl
    >>> lines = fl.scenes.make("spaghetti", 300).lines
    >>> with fl.view(fl.build(lines, "bvh-d2"), against="bvh-cl") as viewer:  # doctest: +SKIP
    ...     viewer.shoot([0.5, 0.5, -1], [0, 0, 1], radius=0.01)
    ...     input(viewer.url)
    """
    viser()  # before the work
    panes = make_panes(tree, against)
    return Viewer(panes, first_choices(panes, color, level, radius), port)


def make_panes(tree: Tree, against: Tree | str | None = None) -> list[Pane]:
    """Check the trees of a page, and build the second one if a method is named."""
    _check_tree(tree, "tree")
    geometry = tree.geometry
    if not len(geometry):
        raise InputError("the tree is over no primitives, so there is nothing to view; expected at least one")
    trees = [tree]
    if isinstance(against, str):
        trees.append(build(geometry, against))
    elif against is not None:
        _check_tree(against, "against")
        other = against.geometry
        if len(other) != len(geometry) or not np.array_equal(other.bounds, geometry.bounds):
            raise InputError(
                f"against is over {other.count_text()}, and the tree over {geometry.count_text()}; expected a second "
                "tree over the same lines"
            )
        trees.append(against)
    names = [each.method for each in trees]
    if len(set(names)) < len(names):
        names = [f"{name} {i}" for i, name in enumerate(names, 1)]
    return [Pane(each, name, f"/{i}") for i, (each, name) in enumerate(zip(trees, names, strict=True))]


def _check_tree(tree: object, name: str) -> None:
    if isinstance(tree, Tree):
        return
    hint = "build one first, as in fl.view(fl.build(lines))"
    if isinstance(tree, Node):
        hint = "pictures of trees of fl.theory are drawn by fl.drawing"
    raise InputError(f"{name} is {type(tree).__name__}; expected a Tree: {hint}")


def first_choices(
    panes: list[Pane], color: str | None = None, level: int | None = None, radius: float | None = None
) -> Choices:
    """Return what a page shows first."""
    choices, tree = Choices(), panes[0].tree
    if radius is None:
        radius = SMALL * SceneFrame.around(tree).size if tree.geometry.needs_radius else 0.0
    choices.radius = float(f"{number('radius', radius, 'a number from 0', 0.0):.4g}")
    if color is not None:
        choices.color = check_color(color, panes[0].tree.geometry)
    levels = max((pane.outline.levels for pane in panes), key=len)
    many = [i for i, nodes in enumerate(levels) if len(nodes) > FEW_BOXES]
    choices.level = many[0] - 1 if many else len(levels) - 1
    if level is not None:
        choices.level = count("level", level, 0, len(levels) - 1)
    return choices
