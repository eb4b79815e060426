"""``fastlines pairs``: find lines that come near each other."""

from __future__ import annotations

import json
import time
from contextlib import nullcontext
from typing import Annotated, Any

import typer
from typer import Option

from ..support.texts import counted
from .options import (
    ASKED_HELP,
    AskedInput,
    Distance,
    FormatName,
    FormatOptions,
    Json,
    OwnSurface,
    Skip,
    TableFile,
    To,
    refuse_given,
)

#: How much memory the pairs that are found at a time may take.
MAX_BYTES = 64 << 20


def pairs(
    source: AskedInput,
    radius: Distance,
    other: Annotated[
        str | None,
        Option(metavar="INPUT2", help=f"Pair the lines of INPUT with those of this input. {ASKED_HELP}"),
    ] = None,
    skip_neighbours: Annotated[
        int | None,
        Option(
            metavar="N",
            help="Leave out pairs of a strand that are at most N segments apart. The default, 1, leaves out those that "
            "share a joint.",
            show_default=False,
        ),
    ] = None,
    skip_strand: Annotated[bool, Option("--skip-strand", help="Leave out all pairs of the same strand.")] = False,
    to: To = None,
    own_radius: OwnSurface = True,
    points: Annotated[
        bool, Option("--points", help="Add the nearest places: columns x_i, y_i, z_i and x_j, y_j, z_j.")
    ] = False,
    output: TableFile = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
    as_json: Json = False,
) -> None:
    """Find all pairs of lines within a distance of each other, and write a table.

    Each pair has one row. Rows are sorted by i, then by j. The columns are i and j, the two segments, i < j where both
    are of INPUT; part, row and strand of both, such as strand_i, if there are parts, skipped rows or strands; s and t,
    the nearest places on them from 0 to 1; and distance. Pairs are found and written in parts, so that a table may be
    larger than the memory.

    [bold]Examples[/]

    [cyan]fastlines pairs yarn.bcc --radius 0.01 -o contacts.csv[/]

    [cyan]fastlines pairs axon.swc --other dendrite.swc --radius 2 --points -o contacts.parquet[/]

    [cyan]fastlines pairs cables.vtp --radius 0.5 --skip-strand[/]
    """
    from .answer_columns import columns_of_pairs, no_pairs
    from .files import open_beside, open_input, show_progress, tree_of
    from .tables import check_table, table_writer

    check_table(output, (source, other))
    options: dict[str, Any] = {"to": to, "max_bytes": MAX_BYTES, "progress": show_progress()}
    skips = {"skip_neighbours": skip_neighbours, "skip_strand": skip_strand or None}
    if other is not None:
        given = {f"--{name.replace('_', '-')}": value for name, value in skips.items()}
        refuse_given(given, "pairs with --other have no neighbours")
    options |= {name: value for name, value in skips.items() if value is not None}
    opened = open_input(source, skip_invalid, format, option, own_radius, forests=True)
    both = [opened] if other is None else [opened, open_beside(opened, other, skip_invalid, own_radius)]
    trees = [tree_of(of) for of in both]

    # Write the pairs of each part before the next ones are found.
    start, n_pairs = time.perf_counter(), 0
    with nullcontext() if output is None else table_writer(output) as append:
        if append is not None:
            append(columns_of_pairs(no_pairs(both[0].geometry, both[-1].geometry), points))
        for part in trees[0].iter_pairs(radius, *trees[1:], **options):
            n_pairs += len(part)
            if append is not None:
                append(columns_of_pairs(part, points))
    seconds = time.perf_counter() - start
    if as_json:
        facts = {"radius": radius, "n_pairs": n_pairs, "seconds": seconds, "output": output}
        typer.echo(json.dumps(facts, indent=2))
        return
    typer.echo(f"{output or opened.name}: {counted(n_pairs, 'pairs')} within {radius:g}, in {seconds:.3f} s")
