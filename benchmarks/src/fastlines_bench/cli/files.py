"""``fastlines-bench files``: how fast files of streamlines are read, and in how much memory."""

from __future__ import annotations

from typing import Annotated

import typer

from ..studies.files import PEERS, FilesPreset, print_files, run_files
from .app import app
from .options import JsonFile, Quick, Rounds, check_files, check_names, progress_bar, write_json


@app.command(short_help="The time and the memory in which files are read.")
def files(
    segments: Annotated[
        int | None,
        typer.Option(
            "--segments",
            "-n",
            help="The number of segments in each file; the default is 10 million.",
            min=1,
            show_default=False,
        ),
    ] = None,
    per_strand: Annotated[
        int, typer.Option("--per-strand", help="The mean number of segments of a streamline.", min=1)
    ] = 50,
    extension: Annotated[
        list[str] | None,
        typer.Option(
            "--format",
            metavar=".EXT,…",
            help="The formats, separated by commas; the default is all.",
            show_default=False,
        ),
    ] = None,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Read generated files by fastlines and by the libraries of their formats, as far as they are installed.

    Each reader runs in a process of its own. The libraries are nibabel (.trk, .tck), trx-python (.trx) and usd-core
    (.usdc).

    [bold]Examples[/]

    [cyan]fastlines-bench files --quick[/]

    [cyan]fastlines-bench files --json files.json[/]  10 million segments: some minutes and 3 GB of memory

    [cyan]fastlines-bench files --segments 1000000 --per-strand 6 --format .trk[/]
    """
    check_files(json_file)
    formats = check_names("--format", "format", extension, PEERS)
    preset = FilesPreset.of(quick, n_segments=segments, per_strand=per_strand, rounds=rounds, formats=formats)
    with progress_bar() as progress:
        result = run_files(preset, progress)
    print_files(result)
    write_json(json_file, result.to_json())
