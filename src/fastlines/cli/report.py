"""``fastlines report``: which tree suits some lines."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import InputError
from .app import app
from .options import Input, Skip


@app.command(short_help="Find which tree suits your lines.")
def report(
    source: Input,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="Write the page to this folder.")
    ] = "fastlines-report",
    quick: Annotated[bool, typer.Option("--quick", help="Use fewer rays and smaller pictures.")] = False,
    skip_invalid: Skip = False,
) -> None:
    """Build the five trees of the thesis and the default tree over your lines, and report which one suits them.

    [bold]Examples[/]

    [cyan]fastlines report hair.tfx -o hair-report[/]

    [cyan]fastlines report scene:bun-hair --quick[/]
    """
    from ..report import FULL, QUICK, report_page
    from .files import open_lines, show_progress

    if source == "thesis":
        raise InputError(
            "another command makes the thesis's chapter 6: in a checkout of the repository, run  "
            "pip install ./benchmarks  and then  fastlines-bench thesis"
        )
    opened = open_lines(source, skip_invalid)
    camera = opened.camera(None, None, 30.0, 1.0)
    preset = QUICK if quick else FULL
    page = report_page(output, preset, opened.name, opened.lines, camera, show_progress=show_progress())
    typer.echo(f"the page is {page}")
