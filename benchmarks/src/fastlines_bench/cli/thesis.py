"""``fastlines-bench thesis``: chapter 6 of the thesis repeated."""

from __future__ import annotations

from typing import Annotated

import typer

from ..harness.internals import note, show_progress
from ..thesis.preset import ThesisPreset
from ..thesis.run import make_thesis, missing_peer
from .app import app
from .options import Peer, Quick


@app.command(short_help="Chapter 6 of the thesis repeated, side by side with its own figures.")
def thesis(
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="The folder for the page.")
    ] = "fastlines-thesis",
    peer: Peer = "embree",
    quick: Quick = False,
) -> None:
    """Build the thesis's five trees, ours and Embree's over its five scenes; time and draw them, and write a page.

    The page has tables 6.1 to 6.5 with the thesis's own figures next to ours, and checks its findings. An interrupted
    run resumes when the command is repeated with the same folder.

    [bold]Examples[/]

    [cyan]fastlines-bench thesis --quick[/]  under three minutes

    [cyan]fastlines-bench thesis -o results[/]  under half an hour on two cores
    """
    preset = ThesisPreset.of(quick, peer=peer != "none")
    if preset.peer and (missing := missing_peer(preset)):
        note(f"Embree is missing: {missing}")
    try:
        page = make_thesis(output, preset, show_progress=show_progress())
    except KeyboardInterrupt:
        note(f"finished steps are kept in {output}; the same command resumes there")
        raise
    typer.echo(f"the page is {page}")
