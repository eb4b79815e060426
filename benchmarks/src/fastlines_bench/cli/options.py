"""Options of several commands, their checks, and the output of results."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer

from fastlines import InputError

from ..harness import plot as plots
from ..harness.internals import atomic_write, check_output, did_you_mean, show_progress

Scenes = Annotated[
    list[str] | None,
    typer.Option(
        "--scene",
        "-s",
        metavar="NAME",
        help="A scene: NAME, NAME:SEGMENTS or NAME:SEGMENTS:SEED. Repeat for more; the default is all five.",
        show_default=False,
    ),
]
Files = Annotated[
    list[str] | None,
    typer.Option(
        "--file",
        "-f",
        metavar="FILE",
        help="A file of lines or a tree, instead of scenes or besides them. Repeat for more.",
        show_default=False,
    ),
]
Seconds = Annotated[
    float | None,
    typer.Option(
        "--seconds", help="The approximate time of one round of the slowest side.", min=0.0, show_default=False
    ),
]
OneRadius = Annotated[
    str | None,
    typer.Option(
        "--radius",
        "-r",
        help="The radius; the default is 0.001 for scenes, and this share of the box's largest side for files.",
        show_default=False,
    ),
]
Radii = Annotated[str, typer.Option("--radius", "-r", metavar="R,R,…", help="The radii, separated by commas.")]
NRays = Annotated[
    int | None, typer.Option("--n-rays", help="The maximum number of rays for one figure.", min=64, show_default=False)
]
Rounds = Annotated[
    int | None,
    typer.Option(
        "--rounds",
        help="The number of rounds, in each of which all sides run once.",
        min=1,
        show_default=False,
    ),
]
Threads = Annotated[int, typer.Option("--threads", "-t", help="The number of threads of all sides.", min=1, max=1024)]
Peer = Annotated[str, typer.Option("--peer", help="The peer that is measured too: embree or none.")]
Quick = Annotated[bool, typer.Option("--quick", help="Use smaller scenes and fewer rays, for a minute or less.")]
JsonFile = Annotated[str | None, typer.Option("--json", metavar="FILE", help="Write all figures to this file.")]
PlotFile = Annotated[str | None, typer.Option("--plot", metavar="FILE.png", help="Draw the figures into this file.")]


def check_files(json_file: str | None, plot: str | None = None) -> None:
    """Raise an error before the work if a file could not be written after it."""
    check_output(json_file, ".json")
    check_output(plot, ".png")
    if plot is not None:
        plots.check()


def write_json(path: str | None, result: Any) -> None:
    """Write figures to a file, atomically, if there is a path."""
    if path is not None:
        with atomic_write(path) as partial:
            partial.write_text(json.dumps(result, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def write_plot(path: str | None, draw: Callable[[Any, Any], None], result: Any) -> None:
    """Draw a result into a file, atomically, if there is a path."""
    if path is not None:
        with atomic_write(path) as partial:
            draw(result, partial)


def check_peer(peer: str, n_threads: int) -> bool:
    """Return whether the option --peer names a peer; raise an error if it is unknown or cannot be used."""
    if peer not in ("embree", "none"):
        raise InputError(f"--peer {peer!r} is not a choice: use embree or none")
    if peer == "embree":
        from ..peers.embree import load

        load(n_threads)
    return peer == "embree"


def check_kinds(rays: str, known: Iterable[str]) -> tuple[str, ...]:
    """Return the kinds of the option --rays."""
    kinds = tuple(rays.split(","))
    for kind in kinds:
        if kind not in known:
            raise InputError(f"--rays {kind!r} is not a choice: use one or more of {', '.join(known)}")
    return kinds


def check_names(option: str, what: str, texts: list[str] | None, known: Iterable[str]) -> tuple[str, ...] | None:
    """Return the distinct names of an option with comma-separated names; None if it is not given."""
    if not texts:
        return None
    names = [name for text in texts for name in text.split(",")]
    for name in names:
        if name not in known:
            raise InputError(f"{option} {name!r} is not a {what}{did_you_mean(name, tuple(known))}")
    return tuple(dict.fromkeys(names))


def check_counts(option: str, text: str, most: int, such: str) -> tuple[int, ...]:
    """Return the distinct whole numbers of a comma-separated list."""
    found = []
    for part in text.split(","):
        if not (part.isascii() and part.isdigit() and len(part) < 20 and 1 <= int(part) <= most):
            shown = part if len(part) < 100 else part[:100] + "…"
            raise InputError(
                f"{option} {shown!r} is not a whole number from 1 to {most}; expected one or more, such as {such}"
            )
        found.append(int(part))
    return tuple(dict.fromkeys(found))


@contextmanager
def progress_bar() -> Iterator[Callable[[str, float], None]]:
    """Yield a function that shows the progress on a terminal, or that does nothing without one."""
    if not show_progress():
        yield lambda what, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda what, share: bar.update(task, description=f"{what:<60}", completed=share)
