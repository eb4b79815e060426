"""``fastlines view``: a tree in the browser."""

from __future__ import annotations

import time
import webbrowser
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option

from ..arrays import choice
from ..errors import InputError
from .files import note, open_lines, show_progress
from .options import FormatName, FormatOptions, Input, OwnRadius, Skip, finite, refuse_given

if TYPE_CHECKING:
    from ..viewer.viewer import Viewer


def view(
    source: Input,
    method: Annotated[
        str | None, Option("--method", "-m", metavar="NAME", help="The kind of tree to build; best by default.")
    ] = None,
    against: Annotated[
        str | None,
        Option(metavar="NAME", help="Build another kind of tree, too, and shoot each ray into both: bvh-cl, kd-d2, …"),
    ] = None,
    color: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="Colour lines by direction, strand, depth, leaf size, cost, radius or an attribute.",
        ),
    ] = None,
    level: Annotated[int | None, Option(min=0, help="Show the boxes of this level first.")] = None,
    origin: Annotated[str | None, Option(metavar="X,Y,Z", help="Shoot a ray from here first.")] = None,
    direction: Annotated[str | None, Option(metavar="X,Y,Z", help="The direction of that ray.")] = None,
    radius: Annotated[
        float | None,
        Option("--radius", "-r", callback=finite, help="How near rays must come, in the unit of the coordinates."),
    ] = None,
    lines: Annotated[
        str,
        Option(metavar="WHICH", help="Show all lines first, those tested by the ray, its hits, or none."),
    ] = "all",
    both: Annotated[bool, Option("--both", help="Show the tree of --against beside the first one.")] = False,
    port: Annotated[
        int | None,
        Option(min=1, max=65535, help="Serve on this port; by default on the first free one from 8080 on."),
    ] = None,
    open_page: Annotated[
        bool, Option("--open/--no-browser", help="Whether to open the page in the browser, too.")
    ] = False,
    export: Annotated[
        str | None,
        Option(metavar="FILE.html", help="Write the scene as a page that opens without a server, and serve nothing."),
    ] = None,
    own_radius: OwnRadius = True,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
) -> None:
    """Show a tree in the browser: its lines, its boxes, and the way of a ray through it.

    The page is served on the loopback address, 127.0.0.1, which other machines do not reach. Ctrl-C ends it. A click
    on the page shoots a ray. The command needs the extra 'view'.

    [bold]Examples[/]

    [cyan]fastlines view hair.tfx[/]

    [cyan]fastlines view scene:spaghetti-2 --method bvh-d2 --against bvh-cl[/]

    [cyan]fastlines view streamlines.vtp --color speed --open[/]

    [cyan]fastlines view hair.flt --level 6 --export hair.html[/]

    [cyan]fastlines view scene:spaghetti --origin 0.5,0.5,-1 --direction 0,0,1 --radius 0.02 --lines tested[/]
    """
    from ..builder import build
    from ..tree import Tree
    from ..viewer.choices import SHOWN
    from ..viewer.export import check_page_path, write_page
    from ..viewer.server import PORTS, free_port, viser
    from ..viewer.shot import make_ray, read_vector
    from ..viewer.view import first_choices, make_panes
    from ..viewer.viewer import Viewer

    # Check what is cheap to check before the work.
    viser()
    choice("--lines", lines, SHOWN)
    if both and against is None:
        raise InputError("--both shows two trees; name the second one with --against")
    if (origin is None) != (direction is None):
        raise InputError("--origin and --direction belong together; give both of them")
    if export is not None:
        refuse_given({"--port": port, "--open": open_page or None}, "--export serves nothing")
        check_page_path(export)
    elif port is not None:
        free_port(port)
    opened = open_lines(source, skip_invalid, format, option, own_radius)
    if isinstance(opened.tree, Tree):
        refuse_given({"--method": method}, f"{source} is a tree already")
        tree = opened.tree
    else:
        tree = build(opened.geometry, method, progress=show_progress())
    panes = make_panes(tree, against)
    choices = first_choices(panes, color, level, radius)
    choices.lines, choices.side = SHOWN[lines], 2 if both else 0
    if origin is not None and direction is not None:
        start, along = read_vector(origin, "--origin"), read_vector(direction, "--direction")
        choices.ray = make_ray(tree, start, along, choices.radius)
    if export is not None:
        write_page(export, panes, choices)
        typer.echo(f"{export}: {tree!r}")
        return
    viewer = Viewer(panes, choices, port)
    if port is None and viewer.port != PORTS[0]:
        note(f"port {PORTS[0]} is in use; the page is on port {viewer.port}")
    _serve(viewer, f"{source}: {tree!r}", open_page)


def _serve(viewer: Viewer, about: str, open_page: bool) -> None:
    """Serve until Ctrl-C."""
    with viewer:
        typer.echo(about)
        try:
            typer.echo(f"{viewer.url}   (Ctrl-C ends)")
            if open_page:
                webbrowser.open(viewer.url)
            while True:
                time.sleep(3600)
        except KeyboardInterrupt:
            typer.echo("ended")
