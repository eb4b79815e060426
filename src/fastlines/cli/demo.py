"""``fastlines demo``: the thesis's five trees over its five scenes."""

from __future__ import annotations

from typing import Annotated

import typer

from .app import app


@app.command(short_help="Five trees over five scenes: a page of figures and pictures.")
def demo(
    quick: Annotated[bool, typer.Option("--quick", help="Smaller scenes and fewer rays: under a minute.")] = False,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="Where to write the page and its pictures.")
    ] = "fastlines-demo",
) -> None:
    """Build the five trees of the thesis over its five scenes, time them, draw them, and write a page about it.

    All answers are compared while they are timed: every tree must give the same, bit for bit.

    [bold]Examples[/]

    [cyan]fastlines demo --quick[/]

    [cyan]fastlines demo -o results[/]  takes some minutes
    """
    from ..demo import FULL, QUICK, run_demo
    from .files import show_progress

    page = run_demo(output, QUICK if quick else FULL, show_progress=show_progress())
    typer.echo(f"the page is {page}")
