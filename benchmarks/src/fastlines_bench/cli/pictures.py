"""``fastlines-bench pictures``: how long pictures take, and how soon the first one is there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fastlines import InputError

from ..studies.pictures.cases import GALLERY, Case, gallery
from ..studies.pictures.run import PicturesPreset, run_pictures
from ..studies.pictures.show import print_pictures
from .app import app
from .options import Files, JsonFile, Quick, Rounds, Threads, check_files, check_names, progress_bar, write_json


@app.command(short_help="How long pictures take, and how soon the first one is there.")
def pictures(
    name: Annotated[
        list[str] | None,
        typer.Option(
            "--picture",
            metavar="NAME,…",
            help="Pictures of the gallery, such as sintel,brain; the default is all.",
            show_default=False,
        ),
    ] = None,
    file: Files = None,
    data: Annotated[
        str | None,
        typer.Option("--data", metavar="FOLDER", help="The folder of the gallery's files.", show_default=False),
    ] = None,
    million: Annotated[
        bool, typer.Option("--million", help="A head of a million strands: 1024² pixels, 64 samples, traced paths.")
    ] = False,
    peer: Annotated[str, typer.Option("--peer", help="The peer that is timed too: pyvista or none.")] = "pyvista",
    threads: Threads = 2,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Time the default pictures of the gallery, beside PyVista's tubes of the same lines if it is installed.

    Each picture is made by ``fastlines render`` in a process of its own. Pictures whose files are not in the folder of
    data are left out.

    [bold]Examples[/]

    [cyan]fastlines-bench pictures --quick[/]

    [cyan]fastlines-bench pictures --data FOLDER --json pictures.json[/]  a quarter of an hour

    [cyan]fastlines-bench pictures --file hair.tfx --rounds 1[/]

    [cyan]fastlines-bench pictures --picture sintel --data FOLDER --million[/]
    """
    check_files(json_file)
    if data is not None and not Path(data).is_dir():
        raise InputError(f"--data {data!r} is not a folder; expected one with files of the gallery")
    (peer,) = check_names("--peer", "peer", [peer], ("pyvista", "none")) or (peer,)
    names = check_names("--picture", "picture of the gallery", name, GALLERY)
    found, missing = gallery(data, names, quick) if names or not (file or million) else ([], [])
    own = [Case(Path(each).name, each) for each in file or []]
    for case in own:
        if not case.is_there:
            raise InputError(f"--file {case.source!r}: there is no such file; expected a file of lines or a tree")
    given = {"n_threads": threads, "rounds": rounds, "peer": peer == "pyvista", "data": data, "dense": million}
    preset = PicturesPreset.of(quick, **given)
    with progress_bar() as progress:
        result = run_pictures([*found, *own], missing, preset, progress)
    print_pictures(result)
    write_json(json_file, result.to_json())
