"""``fastlines scene``: make one of the thesis's scenes."""

from __future__ import annotations

from typing import Annotated

import typer

from .app import app


@app.command(short_help="Make one of the five scenes of the thesis.")
def scene(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="The scene to make; by default all are listed.")
    ] = None,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="FILE.npz", help="The file to write; NAME.npz by default."),
    ] = None,
    n_segments: Annotated[
        int | None, typer.Option("--segments", "-n", help="The number of segments; the thesis's number by default.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", "-s", help="Another seed gives another scene of the same kind.")] = 0,
) -> None:
    """Make one of the five scenes of the thesis, as a file of lines.

    The file holds the arrays segments (n, 2, 3) and strands (n,); fl.read and all commands read it.

    [bold]Examples[/]

    [cyan]fastlines scene[/]  lists the scenes

    [cyan]fastlines scene spaghetti -o spaghetti.npz[/]

    [cyan]fastlines scene bun-hair -n 20000 --seed 7 -o hair.npz[/]
    """
    from .. import scenes
    from .files import check_output, write_npz

    if name is None:
        for known in scenes.NAMES:
            recipe = scenes.make(known)
            typer.echo(f"{known:<15}{len(recipe.lines):>7,} segments   {recipe.title}")
        return
    output = output or f"{name}.npz"
    check_output(output, ".npz")
    made = scenes.make(name, n_segments, seed)
    write_npz(output, segments=made.lines.segments, strands=made.lines.strands)
    typer.echo(f"{output}: {made.title}, {len(made.lines):,} segments, {made.lines.n_strands:,} strands")
