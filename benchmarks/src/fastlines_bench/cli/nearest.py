"""``fastlines-bench nearest``: the nearest segments of points, beside libigl, fcpw and k-d trees."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fastlines import InputError

from ..peers.closest_points import PEERS, check_installed, is_installed
from ..proximity import scenes
from ..proximity.nearest import NearestPreset, run_nearest
from ..proximity.show_nearest import print_nearest
from .app import app
from .options import Files, JsonFile, Quick, Rounds, Threads, check_files, check_names, progress_bar, write_json


@app.command(short_help="The nearest segments of points, beside libigl, fcpw and k-d trees.")
def nearest(
    scene: Annotated[
        list[str] | None,
        typer.Option(
            "--scene",
            "-s",
            metavar="NAME",
            help="A scene: NAME or NAME:SEGMENTS. Repeat for more; the default is neuron, bun-hair, "
            "straight-hair, tracts and spaghetti.",
            show_default=False,
        ),
    ] = None,
    file: Files = None,
    data: Annotated[
        str | None,
        typer.Option(
            "--data",
            metavar="FOLDER",
            help="A folder with Neuron.swc and stroke.trk.gz, which replace the generated neuron and tracts.",
            show_default=False,
        ),
    ] = None,
    peer: Annotated[
        list[str] | None,
        typer.Option(
            "--peer",
            metavar="NAME,…",
            help="The peers: libigl, fcpw, scipy, pykdtree; or none. The default is all that are installed.",
            show_default=False,
        ),
    ] = None,
    n_points: Annotated[
        int | None, typer.Option("--n-points", help="The number of points.", min=2, show_default=False)
    ] = None,
    threads: Threads = 1,
    rounds: Rounds = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Find the 1 and the 8 nearest segments of points, half of which are near the lines; compare times and distances.

    The same points are searched for all segments within a dense and a sparse radius, beside rays without a length.

    [bold]Examples[/]

    [cyan]fastlines-bench nearest --quick[/]

    [cyan]fastlines-bench nearest --data FOLDER --json nearest.json[/]  some minutes

    [cyan]fastlines-bench nearest --scene bun-hair:1000000 --peer fcpw --threads 2[/]
    """
    check_files(json_file)
    if data is not None and not Path(data).is_dir():
        raise InputError(f"--data {data!r} is not a folder; expected one with Neuron.swc and stroke.trk.gz")
    names = list(scene or ([] if file else scenes.SIZES))
    subjects = [scenes.make(name, data, quick) for name in names]
    subjects += [scenes.PointScene(Path(name).name, name, scenes.read_axes(name)) for name in file or []]
    chosen = () if peer == ["none"] else check_names("--peer", "peer", peer, PEERS)
    for name in chosen or ():
        check_installed(name)
    missing = tuple(name for name in PEERS if not is_installed(name)) if chosen is None else ()
    peers = chosen if chosen is not None else tuple(name for name in PEERS if name not in missing)
    preset = NearestPreset.of(quick, n_points=n_points, n_threads=threads, rounds=rounds, peers=peers)
    with progress_bar() as progress:
        result = run_nearest(subjects, preset, missing, progress)
    print_nearest(result)
    write_json(json_file, result.to_json())
