"""``fastlines forest build``, ``info`` and ``verify``: forests of trees over lines that do not fit into memory."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Option

import fastlines as fl

from ..forest.manifest import FILE
from ..forest.mapping.connect import connected
from ..geometry.offsets import OFFSET
from ..io import format_of
from ..support.texts import bytes_text, counted
from .files import offset_of, show_progress
from .options import FormatName, FormatOptions, Json, Memory, Skip, format_options, n_bytes

Folder = Annotated[str, typer.Argument(metavar="FOREST", help="The folder of a forest.")]


def build(
    sources: Annotated[
        list[str],
        typer.Argument(metavar="INPUT…", help="Files of lines, in their order, or a folder of Parquet files."),
    ],
    output: Annotated[str, Option("--output", "-o", metavar="FOLDER", help="The folder to build the forest in.")],
    max_segments: Annotated[
        int | None,
        Option("--max-segments", "-n", help="The most segments of a tile; by default as many as the memory takes."),
    ] = None,
    memory: Memory = None,
    method: Annotated[
        str | None, Option("--method", "-m", metavar="NAME", help="The kind of trees; best by default.")
    ] = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
    scheduler: Annotated[
        str | None,
        Option(
            metavar="ADDRESS",
            help="Build the tiles on the workers of this Dask scheduler, or of one on this machine: local.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Build a forest: a folder with a tree for each tile of the scene.

    The lines are read in parts, so they need not fit into memory. A build that was stopped goes on when the same
    command runs again, and makes the same files.

    [bold]Examples[/]

    [cyan]fastlines forest build tracts.trk -o tracts.forest[/]

    [cyan]fastlines forest build subject1.tck subject2.tck subject3.tck --memory 4GB -o cohort.forest[/]

    [cyan]fastlines forest build traces.parquet --max-segments 2000000 -o traces.forest[/]
    """
    invalid = "skip" if skip_invalid else "error"
    texts = [text for text in option or () if not text.startswith(f"{OFFSET}=")]
    offsets = [text.removeprefix(f"{OFFSET}=") for text in option or () if text not in texts]
    offset = offset_of(offsets[-1]) if offsets else None
    given: Any = sources
    if format is not None or texts:
        given = _chunks(sources, format, texts, offset=offset, invalid=invalid)
    start, before = time.perf_counter(), _version_of(output)
    with nullcontext() if scheduler is None else connected(scheduler) as client:
        forest = fl.build_forest(
            given,
            output,
            max_segments=max_segments,
            memory=None if memory is None else n_bytes(memory, "--memory"),
            method=method,
            offset=offset,
            invalid=invalid,
            map=client,
            progress=show_progress(),
        )
    seconds = time.perf_counter() - start
    if as_json:
        typer.echo(json.dumps({"inputs": sources, "output": output, "seconds": seconds, **forest.stats()}, indent=2))
        return
    done = "was whole, verified" if before == _version_of(output) else "built"
    typer.echo(f"{output}: {_described(forest)}, {done} in {seconds:.2f} s")


def info(folder: Folder, as_json: Json = False) -> None:
    """Describe a forest: its segments, tiles, box and attributes.

    [bold]Examples[/]

    [cyan]fastlines forest info tracts.forest[/]

    [cyan]fastlines forest info tracts.forest --json[/]
    """
    from .info import facts_text

    forest = fl.Forest(folder)
    facts = {"lines": forest.geometry.summary(), "forest": forest.stats()}
    if as_json:
        typer.echo(json.dumps({"name": folder, **facts}, indent=2))
        return
    typer.echo(folder)
    for line in facts_text(facts):
        typer.echo(line)


def verify(folder: Folder, as_json: Json = False) -> None:
    """Check every file of a forest: that it is there, whole, of this forest, and a usable tree.

    [bold]Examples[/]

    [cyan]fastlines forest verify tracts.forest[/]

    [cyan]fastlines forest verify tracts.forest --json[/]
    """
    forest = fl.Forest(folder)
    forest.verify(progress=show_progress())
    if as_json:
        typer.echo(json.dumps({"valid": True, **forest.stats()}, indent=2))
        return
    typer.echo(f"{folder}: whole: {_described(forest)}")


def _chunks(sources: list[str], format: str | None, texts: list[str] | None, **how: Any) -> Iterator[fl.Lines]:
    """Yield the chunks of files that are read with options of their format."""
    for source in sources:
        known = format_of(Path(source), format).options()
        yield from fl.read_chunks(source, format=format, **how, **format_options(texts, known))


def _version_of(folder: str) -> int | None:
    """Return when the manifest of a forest was written; None if there is none."""
    path = Path(folder) / FILE
    return path.stat().st_mtime_ns if path.exists() else None


def _described(forest: fl.Forest) -> str:
    """Return what a forest holds, in words."""
    stats = forest.stats()
    tiles, size = counted(stats["n_tiles"], "tiles"), bytes_text(stats["file_bytes"])
    return f"{forest.geometry.count_text()}, {tiles}, {size}"
