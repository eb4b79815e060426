"""``fastlines nearest`` and ``fastlines within``: find what is near points."""

from __future__ import annotations

from typing import Annotated

import typer
from typer import Option

from .options import AskedInput, Distance, FormatName, FormatOptions, Json, OwnSurface, Skip, TableFile, To, finite
from .point_query import PointQuery

Points = Annotated[
    str,
    typer.Argument(
        metavar="POINTS",
        help="A point X,Y,Z, or a file: an array (n, 3) in .npy, or 'points' in .npz; columns x, y and z in .csv, .tsv "
        "or .parquet; or the points of a file of lines.",
    ),
]
Samples = Annotated[
    list[str] | None,
    Option("--sample", metavar="NAME", help="Add a column: an attribute, or radius, at each place; may be repeated."),
]
Ignore = Annotated[
    str | None,
    Option(
        metavar="N,N,…",
        help="Primitives to leave out: their numbers, or a .npy file, (k,) for all points or (n, m) for each.",
    ),
]
IgnoreStrands = Annotated[str | None, Option(metavar="N,N,…", help="Strands to leave out, likewise.")]
Parts = Annotated[str | None, Option(metavar="N,N,…", help="The parts to search, of a tree of several.")]


def nearest(
    source: AskedInput,
    points: Points,
    k: Annotated[int, Option("--nearest", "-k", metavar="N", help="How many primitives to find for each point.")] = 1,
    max_distance: Annotated[
        float | None,
        Option(callback=finite, metavar="D", help="Find nothing farther away than this.", show_default=False),
    ] = None,
    to: To = None,
    own_radius: OwnSurface = True,
    output: TableFile = None,
    sample: Samples = None,
    ignore: Ignore = None,
    ignore_strands: IgnoreStrands = None,
    parts: Parts = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
    as_json: Json = False,
) -> None:
    """Find the line, or other primitive, nearest to each point, and write a table.

    Each point has a row, or N rows with --nearest N. The columns are point, the number of the point from 0; x, y and z,
    the nearest place; prim, the primitive; u, the place on it from 0 to 1; and distance. The columns part, row and
    strand follow if the input has parts, skipped rows or strands. What a miss lacks is an empty cell in CSV, null in
    Parquet, and -1, inf or NaN in a .npz file. The rows of a point X,Y,Z are printed if no file is named.

    [bold]Examples[/]

    [cyan]fastlines nearest hair.flt points.csv -o nearest.csv[/]

    [cyan]fastlines nearest tracts.trk.gz electrodes.npy -k 4 --max-distance 2 -o nearest.parquet[/]

    [cyan]fastlines nearest neuron.swc 12.5,-3,40 --to axis --sample radius[/]
    """
    asked = PointQuery(source, points, to, output, sample, ignore, ignore_strands, parts, as_json)
    limits = {} if max_distance is None else {"max_distance": max_distance}
    asked.run("nearest", {"k": k, **limits}, (skip_invalid, format, option, own_radius))


def within(
    source: AskedInput,
    points: Points,
    radius: Distance,
    to: To = None,
    own_radius: OwnSurface = True,
    output: TableFile = None,
    sample: Samples = None,
    ignore: Ignore = None,
    ignore_strands: IgnoreStrands = None,
    parts: Parts = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
    as_json: Json = False,
) -> None:
    """Find all lines, or other primitives, within a distance of each point, and write a table.

    Each primitive has a row for each point that is near it. Rows are sorted by point, then by distance. The columns are
    those of [cyan]fastlines nearest[/]: point, x, y, z, prim, u, distance, and part, row and strand if there are any.

    [bold]Examples[/]

    [cyan]fastlines within tracts.trk.gz electrodes.csv --radius 2 -o near.csv[/]

    [cyan]fastlines within hair.flt points.npy --radius 0.01 --sample radius -o near.parquet[/]

    [cyan]fastlines within neuron.swc 12.5,-3,40 --radius 5[/]
    """
    asked = PointQuery(source, points, to, output, sample, ignore, ignore_strands, parts, as_json)
    asked.run("within", {"radius": radius}, (skip_invalid, format, option, own_radius))
