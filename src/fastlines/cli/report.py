"""``fastlines report``: which tree suits some lines."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import InputError
from .app import app
from .options import Input, Skip


@app.command(short_help="Which tree suits your lines.")
def report(
    source: Input,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="Where to write the page.")
    ] = "fastlines-report",
    quick: Annotated[bool, typer.Option("--quick", help="Fewer rays and smaller pictures.")] = False,
    skip_invalid: Skip = False,
) -> None:
    """Build the five trees of the thesis and the default tree over your lines, and say which one suits them.

    [bold]Examples[/]

    [cyan]fastlines report hair.tfx -o hair-report[/]

    [cyan]fastlines report scene:bun-hair --quick[/]
    """
    from ..report import FULL, QUICK, report_page
    from .files import open_lines, show_progress

    if source == "thesis":
        raise InputError(
            "the thesis's chapter 6 is made by another command, of the benchmarks: run  pip install ./benchmarks  in a "
            "checkout of the repository, then  fastlines-bench thesis"
        )
    opened = open_lines(source, skip_invalid)
    camera = opened.camera(None, None, 30.0, 1.0)
    preset = QUICK if quick else FULL
    page = report_page(output, preset, opened.name, opened.lines, camera, show_progress=show_progress())
    typer.echo(f"the page is {page}")
