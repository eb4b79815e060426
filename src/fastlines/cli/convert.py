"""``fastlines convert``: write lines in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from typer import Option

import fastlines as fl

from ..support.texts import counted
from .options import Input, Skip, format_options


def convert(
    source: Input,
    output: Annotated[str, typer.Argument(metavar="OUTPUT", help="The file to write; its extension names the format.")],
    skip_invalid: Skip = False,
    format: Annotated[
        str | None,
        Option(
            "--format", metavar="NAME", help="The format of INPUT, where its extension does not say it; not of OUTPUT."
        ),
    ] = None,
    option: Annotated[
        list[str] | None,
        Option("--option", metavar="NAME=VALUE", help="An option of INPUT's format, such as model=2; may be repeated."),
    ] = None,
    output_option: Annotated[
        list[str] | None,
        Option(
            "--output-option",
            metavar="NAME=VALUE",
            help="An option of OUTPUT's format, such as reference=t1.nii.gz; may be repeated.",
        ),
    ] = None,
) -> None:
    """Read lines and write them in another format. A warning names what that format has no place for.

    The extension of OUTPUT names its format. An extension that cannot be written is an error that lists those that can.

    [bold]Examples[/]

    [cyan]fastlines convert tracts.trk.gz tracts.npz[/]

    [cyan]fastlines convert roads.csv roads.geojson --option column=way[/]

    [cyan]fastlines convert nodes.dat neuron.npz --format swc[/]

    [cyan]fastlines convert tracts.tck tracts.trk --output-option reference=t1.nii.gz[/]

    [cyan]fastlines convert scene:bun-hair hair.npy[/]
    """
    from ..io import to_write
    from ..io.writing import count_strands, parts_to_write
    from .files import check_output, open_input

    row = to_write(Path(output))
    check_output(output, inputs=(source,))
    options = format_options(output_option, row.options("write") if output_option else {}, "--output-option")
    row.check_options(output, options, "write")
    opened = open_input(source, skip_invalid, format, option)
    geometry = opened.geometry
    fl.write(output, geometry, **options)
    # Count what was written, which may be the pieces of curves.
    written = parts_to_write(geometry, row)
    n_strands = sum(count_strands(part, row) for part in written)
    strands = f", {counted(n_strands, 'strands')}" if n_strands else ""
    typer.echo(f"{output}: {row.description}: {fl.Geometry(written).count_text()}{strands}")
