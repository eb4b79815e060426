"""``fastlines convert``: write lines in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import fastlines as fl

from ..geometry import count_text, parts_of
from .app import app
from .options import FormatName, FormatOptions, Input, Skip


@app.command(short_help="Write lines in another format.")
def convert(
    source: Input,
    output: Annotated[str, typer.Argument(metavar="OUTPUT", help="The file to write; its extension names the format.")],
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
) -> None:
    """Read lines and write them in another format. What that has no place for is named in a note.

    [bold]Examples[/]

    [cyan]fastlines convert tracts.trk.gz tracts.npz[/]

    [cyan]fastlines convert roads.csv roads.geojson --option column=way[/]

    [cyan]fastlines convert scene:bun-hair hair.npy[/]
    """
    from ..io import to_write
    from .files import check_output, open_input

    row = to_write(Path(output))
    check_output(output, inputs=(source,))
    opened = open_input(source, skip_invalid, format, option)
    geometry = opened.geometry
    fl.write(output, geometry)
    n_strands = sum(getattr(part, "n_strands", 0) for part in parts_of(geometry))
    strands = f", {n_strands:,} strands" if n_strands else ""
    typer.echo(f"{output}: {row.description}: {count_text(geometry)}{strands}")
