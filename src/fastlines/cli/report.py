"""``fastlines report``: the thesis's chapter 6 made again, or which tree suits somebody's lines."""

from __future__ import annotations

from typing import Annotated

import typer

from .app import app
from .options import Skip

#: Asks for the thesis's scenes instead of a file.
THESIS = "thesis"


@app.command(short_help="The thesis side by side, or which tree suits your lines.")
def report(
    subject: Annotated[
        str,
        typer.Argument(
            metavar="thesis|INPUT",
            help="The thesis's chapter 6, or a file of lines, a tree (.flt) or a scene (scene:NAME).",
            show_default=False,
        ),
    ],
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="Where to write the page.")
    ] = "fastlines-report",
    quick: Annotated[bool, typer.Option("--quick", help="Smaller scenes and fewer rays: under three minutes.")] = False,
    skip_invalid: Skip = False,
) -> None:
    """Build the thesis's five trees, ours and Embree's, ask and draw them, and write a page with all figures.

    With "thesis", over its five scenes, in its tables 6.1 to 6.5 with its own figures beside ours; what it found is
    checked. Stopped and started again with the same folder, it goes on where it was.

    [bold]Examples[/]

    [cyan]fastlines report thesis --quick[/]

    [cyan]fastlines report thesis -o results[/]  under half an hour on two cores

    [cyan]fastlines report hair.tfx -o hair-report[/]  which tree suits these lines
    """
    from ..report import FULL, QUICK, missing_peer, report_lines, report_thesis
    from .files import note, open_lines, show_progress

    plan = QUICK if quick else FULL
    source = None if subject == THESIS else open_lines(subject, skip_invalid)
    if plan.peer and (missing := missing_peer(plan)):
        note(f"Embree is missing: {missing}")
    try:
        if source is None:
            page = report_thesis(output, plan, show_progress=show_progress())
        else:
            camera = source.camera(None, None, 30.0, 1.0)
            page = report_lines(output, plan, source.name, source.lines, camera, show_progress=show_progress())
    except KeyboardInterrupt:
        note(f"the steps that are done are kept in {output}; the same command goes on from there")
        raise
    typer.echo(f"the page is {page}")
