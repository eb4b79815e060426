"""``fastlines demo``: trees side by side, over the five scenes or over lines from a file."""

from __future__ import annotations

from typing import Annotated

import typer

from .app import app
from .options import Skip


@app.command(short_help="Compare trees over five scenes, or your lines, in a page of figures and pictures.")
def demo(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[INPUT]",
            help="A file of lines, a tree (.flt) or a scene (scene:NAME); the five scenes by default.",
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Use smaller scenes and fewer rays: under a minute.")] = False,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="Write the page and its pictures to this folder.")
    ] = "fastlines-demo",
    skip_invalid: Skip = False,
) -> None:
    """Build the five trees of the thesis and the default tree, query and draw them, and write a page of the results.

    All trees must give the same answers, bit for bit.

    [bold]Examples[/]

    [cyan]fastlines demo --quick[/]

    [cyan]fastlines demo -o results[/]  takes some minutes

    [cyan]fastlines demo hair.tfx -o hair[/]  compares trees over your lines
    """
    from ..report import FULL, QUICK, demo_page, report_page
    from .files import open_lines, show_progress

    preset = QUICK if quick else FULL
    if source is None:
        page = demo_page(output, preset, show_progress=show_progress())
    else:
        opened = open_lines(source, skip_invalid)
        camera = opened.camera(None, None, 30.0, 1.0)
        page = report_page(
            output, preset, opened.name, opened.lines, camera, answer=False, show_progress=show_progress()
        )
    typer.echo(f"the page is {page}")
