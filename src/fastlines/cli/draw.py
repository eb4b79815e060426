"""``fastlines draw``: pictures of trees, for papers and slides."""

from __future__ import annotations

from typing import Annotated

import typer
from typer import Option

from .options import FormatName, FormatOptions, Input, Skip


def draw(
    source: Input,
    output: Annotated[str, Option("--output", "-o", metavar="FILE", help="The picture: .svg, .pdf, .png or .webp.")],
    kind: Annotated[
        str,
        Option(metavar="NAME", help="sheet, levels, planes, icicle, leaves, depths, work, partition, graph or thesis."),
    ] = "sheet",
    method: Annotated[
        str | None, Option("--method", "-m", metavar="NAME", help="The kind of tree to build; best by default.")
    ] = None,
    against: Annotated[
        list[str] | None,
        Option(metavar="NAME", help="Another kind of tree over the same lines, drawn beside it; may be repeated."),
    ] = None,
    level: Annotated[
        int | None,
        Option(
            min=0,
            help="The level of levels; six are drawn without it. Of planes, partition, graph and thesis: the last.",
        ),
    ] = None,
    axis: Annotated[
        str | None, Option(metavar="AXIS", help="The axis of view: x, y or z; by default that of the shortest side.")
    ] = None,
    by: Annotated[
        str | None,
        Option(
            metavar="WHAT",
            help="Of icicle: cost or refs. Of leaves and depths: number, share or chance. Of work: nodes or cost.",
        ),
    ] = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
) -> None:
    """Draw a tree: on one page, or one thing about it.

    A [cyan]sheet[/] shows boxes of some levels, cost by node, work a pixel, leaf sizes and depths. [cyan]levels[/] are
    boxes over the lines, and [cyan]planes[/] separate the boxes of siblings. An [cyan]icicle[/] shows what each node
    adds to the cost. [cyan]partition[/] and [cyan]graph[/] are for small trees: boxes or planes with letters, and the
    tree with the same letters. [cyan]thesis[/] shows both beside each other.

    Several trees have one scale, and the costs of the first one's steps and tests. In Python, the functions of
    fastlines.drawing draw on axes of yours.

    [bold]Examples[/]

    [cyan]fastlines draw hair.flt -o hair.png[/]

    [cyan]fastlines draw scene:spaghetti --method bvh-cl --against bvh-d2 --against kd-d2 -o trees.pdf[/]

    [cyan]fastlines draw hair.tfx --kind levels --level 5 -o level.svg[/]

    [cyan]fastlines draw hair.tfx --kind icicle --by refs -o refs.svg[/]

    [cyan]fastlines draw few.csv --method kd-cl --kind thesis -o figure.svg[/]
    """
    from .drawings import Order, write

    order = Order(
        source=source,
        output=output,
        kind=kind,
        methods=[method, *(against or ())],
        level=level,
        axis=axis,
        by=by,
        skip_invalid=skip_invalid,
        format=format,
        option=option,
    )
    typer.echo(write(order))
