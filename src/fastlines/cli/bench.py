"""``fastlines bench``, and ``bench engine``: our engine beside its peers."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError
from .app import Group, app
from .options import Effort, Files, Scenes

if TYPE_CHECKING:
    from ..bench import Case

#: The scenes of --quick.
QUICK_SCENES = ("spaghetti:1000", "straight-hair:10000")
QUICK_RADII = (0.001,)

bench = typer.Typer(cls=Group, rich_markup_mode="rich")
app.add_typer(bench, name="bench", short_help="Our trees beside their peers and each other, and as scenes grow.")


@bench.callback(invoke_without_command=True)
def root(context: typer.Context) -> None:
    """Measure fastlines: beside its peers, on the same rays, answers compared; all its builders; and as scenes grow.

    [bold]Examples[/]

    [cyan]fastlines bench engine --quick[/]

    [cyan]fastlines bench growth --quick[/]

    [cyan]fastlines bench pareto --quick[/]

    [cyan]fastlines bench engine --help[/]
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@bench.command(short_help="Queries of our trees beside Embree's.")
def engine(
    scene: Scenes = None,
    file: Files = None,
    radius: Annotated[
        str | None,
        typer.Option(
            "--radius",
            "-r",
            metavar="R,R,…",
            help="Radii with commas between them; unless given, 0.005, 0.001 "
            "and 0.0005 for scenes, and these shares of the box's largest side for files.",
            show_default=False,
        ),
    ] = None,
    rays: Annotated[
        str, typer.Option("--rays", metavar="KIND,…", help="Kinds of rays: camera, tiled, random, ao.")
    ] = "camera,random,ao",
    n_rays: Annotated[
        int | None,
        typer.Option(
            "--n-rays", help="At most so many rays in a cell; 1048576 unless given.", min=64, show_default=False
        ),
    ] = None,
    threads: Annotated[int, typer.Option("--threads", "-t", help="Threads of both sides.", min=1, max=1024)] = 1,
    method: Annotated[
        str | None,
        typer.Option(
            "--method",
            "-m",
            metavar="NAME",
            help="Our tree; the one that is meant for queries unless given.",
            show_default=False,
        ),
    ] = None,
    effort: Effort = None,
    peer: Annotated[str, typer.Option("--peer", help="embree or none.")] = "embree",
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds", help="About how long one turn of the slower side takes.", min=0.0, show_default=False
        ),
    ] = None,
    rounds: Annotated[
        int | None,
        typer.Option("--rounds", help="How many turns each side has; the best counts.", min=1, show_default=False),
    ] = None,
    retune: Annotated[
        bool, typer.Option("--retune", help="Find anew to what lengths segments are best cut for Embree.")
    ] = False,
    one_by_one: Annotated[
        bool,
        typer.Option("--one-by-one", help="Search each ray alone: our kernel single, and rtcIntersect1."),
    ] = False,
    built_for: Annotated[
        float | None,
        typer.Option(
            "--built-for",
            metavar="R",
            help="Build Embree's user geometry for this radius and ask it, as our tree, with those of --radius.",
            show_default=False,
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Two small scenes, one radius, fewer rays: less than a minute.")
    ] = False,
    json_file: Annotated[
        str | None, typer.Option("--json", metavar="FILE", help="Write all cells with all configurations.")
    ] = None,
    plot: Annotated[str | None, typer.Option("--plot", metavar="FILE.png", help="Draw the rates.")] = None,
) -> None:
    r"""Time queries of our tree and of Embree in turn: the same rays, the same definition of a hit, answers compared.

    Embree comes from the package embreex (pip install "fastlines\[bench]"). It is measured as user geometry, as flat
    and round curves and as ribbons; whole and cut to a length that is tuned for the scene; ray by ray and in packets.
    What counts in a cell is the fastest of them.

    [bold]Examples[/]

    [cyan]fastlines bench engine --quick[/]

    [cyan]fastlines bench engine --json engine.json --plot engine.png[/]  all scenes and radii: many minutes

    [cyan]fastlines bench engine --scene spaghetti --scene bun-hair --radius 0.001 --rays camera,random[/]

    [cyan]fastlines bench engine --file hair.tfx --peer none --threads 2[/]

    [cyan]fastlines bench engine --one-by-one --rays camera,random[/]

    [cyan]fastlines bench engine --radius 0.0005,0.005 --built-for 0.005[/]  one tree for both
    """
    from dataclasses import replace

    from ..bench import Plan, run_engine
    from ..bench.engine import QUICK
    from ..bench.plot import check, draw
    from ..bench.rays import KINDS
    from ..bench.table import print_tables
    from ..methods import method_settings
    from .files import check_output, show_progress

    check_output(json_file, ".json")
    check_output(plot, ".png")
    if plot is not None:
        check()
    kinds = check_kinds(rays, tuple(KINDS))
    if method is not None:
        method_settings(method)
    beside = check_peer(peer, threads)
    given = {"n_rays": n_rays, "seconds": seconds, "rounds": rounds, "method": method, "effort": effort}
    plan = replace(
        QUICK if quick else Plan(),
        kinds=kinds,
        n_threads=threads,
        peer=beside,
        retune=retune,
        one_by_one=one_by_one,
        built_for=built_for,
        **{name: value for name, value in given.items() if value is not None},  # type: ignore[arg-type]
    )
    cases = list(cases_of(scene or [], file or [], radius, quick))
    largest = max(radius for case in cases for radius in case.radii)
    if built_for is not None and (peer == "none" or not largest <= built_for < float("inf")):
        raise InputError(
            f"--built-for {built_for:g}: expected a radius for Embree's trees, no less than the largest that is asked, "
            f"{largest:g}, and --peer embree"
        )
    with progress_bar(show_progress()) as progress:
        result = run_engine(cases, plan, progress)
    print_tables(result)
    if json_file is not None:
        write_json(json_file, result.to_json())
    if plot is not None:
        from ..atomic_write import atomic_write

        with atomic_write(plot) as partial:
            draw(result, partial)


def check_peer(peer: str, n_threads: int) -> bool:
    """Take the option --peer apart: whether there is one, which then can be used."""
    if peer not in ("embree", "none"):
        raise InputError(f"--peer {peer!r} is not a choice: use embree or none")
    if peer == "embree":
        from ..bench.embree import load

        load(n_threads)
    return peer == "embree"


def check_kinds(rays: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """Take the option --rays apart."""
    kinds = tuple(rays.split(","))
    for kind in kinds:
        if kind not in known:
            raise InputError(f"--rays {kind!r} is not a choice: use one or more of {', '.join(known)}")
    return kinds


def write_json(path: str, result: Any) -> None:
    """Write a file that is whole, or not there."""
    from ..atomic_write import atomic_write

    with atomic_write(path) as partial:
        partial.write_text(json.dumps(result, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def cases_of(scene: list[str], file: list[str], radius: str | None, quick: bool) -> Iterator[Case]:
    """What to measure, with which radii."""
    from ..bench import Case
    from ..scenes import NAMES, RADII
    from .files import SCENE, open_lines

    if not scene and not file:
        scene = list(QUICK_SCENES if quick else NAMES)
    for name, is_scene in [*((name, True) for name in scene), *((name, False) for name in file)]:
        source = open_lines(f"{SCENE}{name}" if is_scene else name)
        radii: tuple[float, ...] = QUICK_RADII if quick else tuple(RADII.values())
        if radius is not None:
            radii = tuple(_radius(part) for part in radius.split(","))
        elif not is_scene:
            low, high = source.lines.bounds
            radii = tuple(share * (float((high - low).max()) or 1.0) for share in radii)
        yield Case(name, source.lines, source.camera(None, None, 30.0, 1.0), radii)


def _radius(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 < value < float("inf"):
        raise InputError(f"--radius {text!r} is not a number above 0; expected one or more, such as 0.005,0.001")
    return value


@contextmanager
def progress_bar(show: bool) -> Iterator[Callable[[str, float], None]]:
    """Show what is being measured, if there is someone to look at it."""
    if not show:
        yield lambda what, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda what, share: bar.update(task, description=f"{what:<60}", completed=share)
