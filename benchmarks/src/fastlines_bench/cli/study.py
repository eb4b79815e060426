"""``fastlines-bench study``: studies of single questions, each of which reproduces a table of the docs."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from fastlines import InputError
from fastlines.scenes import NAMES

from ..harness.internals import Group
from ..studies.banner import make_banner
from ..studies.beams import RADII, SIZES, print_beams, trees
from ..studies.bounds import compare_with_bounds
from ..studies.brightness import print_brightness
from ..studies.budgets import SPAGHETTI, print_budgets
from ..studies.hit_frames import print_hit_frames
from ..studies.lookahead import print_lookahead
from ..studies.memory import print_memory
from ..studies.opening import print_opening
from ..studies.options import TABLES, print_options
from ..studies.retraced import AIMS, SCENES, print_retraced
from ..thesis.depths import C_TRAV
from .app import app
from .options import JsonFile, check_counts, check_files, check_names, write_json

study = typer.Typer(cls=Group, rich_markup_mode="rich")
app.add_typer(
    study,
    name="study",
    short_help="Studies of single questions: budgets, memory, options, beams, bounds, retraced, lookahead, opening, "
    "frames, brightness.",
)


@study.callback(invoke_without_command=True)
def root(context: typer.Context) -> None:
    """Study a single question about trees, and reproduce a table of the docs."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def _numbers(option: str, text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"{option} {text!r} is not one or more numbers separated by commas") from None


@study.command()
def budgets(
    scene: Annotated[str, typer.Argument(metavar="NAME:SEGMENTS", help="The scene.")] = SPAGHETTI,
    budget: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME=NUMBER,…]…", help="max_refs, max_bytes, c_trav.", show_default=False),
    ] = None,
) -> None:
    """Build within limits on references or memory; print time, memory and cost as a line of JSON for each build.

    [cyan]fastlines-bench study budgets[/]  spaghetti of 100,000 segments: some minutes

    [cyan]fastlines-bench study budgets bun-hair:10000000 max_bytes=3000000000[/]

    [cyan]fastlines-bench study budgets spaghetti:100000 max_bytes=96000000,c_trav=0.5[/]  the tree of least cost
    """
    print_budgets(scene, budget or [])


@study.command()
def memory(
    lines: Annotated[
        list[str] | None,
        typer.Argument(metavar="[LINES]…", help="Files, NAME:SEGMENTS of scenes, or streamlines:SEGMENTS."),
    ] = None,
    threads: Annotated[str, typer.Option(help="The numbers of threads, separated by commas.")] = "1,2",
) -> None:
    """Build trees in fresh processes; print the peaks of their memory as a line of JSON for each build.

    [cyan]fastlines-bench study memory[/]  scenes and streamlines of up to 4,000,000 segments: some minutes

    [cyan]fastlines-bench study memory tracts.trk.gz --threads 4[/]
    """
    with tempfile.TemporaryDirectory() as folder:
        print_memory(lines or [], [int(n) for n in _numbers("--threads", threads)], Path(folder))


@study.command()
def options(
    table: Annotated[
        list[str] | None,
        typer.Option("--table", metavar="NAME,…", help=f"Some of {', '.join(TABLES)}; the default is all."),
    ] = None,
) -> None:
    """Print the gains and costs of options of the builder: whole splits, lanes, reinsertion, presplit, SBVH."""
    print_options(check_names("--table", "table", table, TABLES) or tuple(TABLES))


@study.command()
def beams(
    segments: Annotated[str, typer.Option("--segments", metavar="N,…", help="The numbers of beams.")] = ",".join(
        map(str, SIZES)
    ),
    radius: Annotated[str, typer.Option("--radius", "-r", metavar="R,…", help="The radii of queries.")] = ",".join(
        map(str, RADII)
    ),
    tree: Annotated[
        list[str] | None, typer.Option("--tree", metavar="NAME,…", help="Some of the trees; the default is all.")
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Print what trees over photon beams take to build, and to query with a picture of 512² pixels.

    [cyan]fastlines-bench study beams[/]  three numbers of beams, each with eight trees: ten minutes

    [cyan]fastlines-bench study beams --segments 1000000 --tree best,beams,bvh-cl --radius 0.002[/]
    """
    check_files(json_file)
    sizes = check_counts("--segments", segments, 2**32 - 16, "36294,200000")
    names = check_names("--tree", "tree", tree, trees(sizes[0]))
    write_json(json_file, print_beams(sizes, _numbers("--radius", radius), names))


@study.command()
def bounds(
    segments: Annotated[
        int | None,
        typer.Option(
            "--segments",
            help="The number of segments of each scene; the default is that of the thesis.",
            min=1,
            show_default=False,
        ),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Compare the costs of trees with a lower bound for all trees, on the thesis's five scenes."""
    check_files(json_file)
    write_json(json_file, compare_with_bounds(segments))


@study.command()
def retraced(
    scene: Annotated[
        str, typer.Option("--scene", metavar="NAME,…", help=f"Some of {', '.join(SCENES)}, and scenes of the thesis.")
    ] = "one-line,apart-0.0005,apart-0.001,apart-0.01,circling",
    effort: Annotated[str, typer.Option("--effort", metavar="N,…", help="Numbers from 0 to 1.")] = "0,0.5",
    aim: Annotated[str, typer.Option("--aim", metavar="NAME,…", help=f"Some of {', '.join(AIMS)}.")] = "queries",
    radius: Annotated[
        str, typer.Option("--radius", metavar="R,…", help="The radii, as shares of the scene's longest side.")
    ] = "0.001,0.0002",
) -> None:
    """Compare trees over lines that run along each other: those of best, and those that cut the lines."""
    print_retraced(
        list(check_names("--scene", "scene", [scene], (*SCENES, *NAMES)) or ()),
        list(check_names("--aim", "aim", [aim], AIMS) or ()),
        _numbers("--effort", effort),
        _numbers("--radius", radius),
    )


@study.command()
def lookahead(
    seed: Annotated[int, typer.Option("--seed", help="The seed of the scene.", min=0)] = 0,
    c_trav: Annotated[float, typer.Option("--c-trav", help="The cost of a step, in tests of a primitive.")] = C_TRAV,
    json_file: JsonFile = None,
) -> None:
    """Reproduce the table of the thesis's §4.3: the gain and the cost of lookahead."""
    check_files(json_file)
    write_json(json_file, {"seed": seed, "c_trav": c_trav, "rows": print_lookahead(seed, c_trav)})


@study.command()
def frames(
    segments: Annotated[int, typer.Option("--segments", help="The number of segments.", min=1)] = 320_000,
    rays: Annotated[int, typer.Option("--rays", help="The number of rays.", min=1)] = 1_000_000,
    threads: Annotated[int, typer.Option("--threads", help="The number of threads.", min=1)] = 1,
) -> None:
    """Time points, normals, tangents and radii of hits on hair, beside the query that found the hits."""
    print_hit_frames(segments, rays, threads)


@study.command()
def opening(
    segments: Annotated[int, typer.Option("--segments", help="The number of segments.", min=1)] = 1_000_000,
) -> None:
    """Time how long it takes to open a saved tree, and to run the first query, with and without a saved layout."""
    print_opening(segments)


@study.command()
def brightness(
    sources: Annotated[
        list[str], typer.Argument(metavar="FILE|SCENE…", help="Hair: files, or scenes such as scene:bun-hair.")
    ],
    color: Annotated[str, typer.Option("--color", help="The colour of the hair.")] = "brown",
    side: Annotated[int, typer.Option("--side", help="The width and the height of pictures.", min=8)] = 128,
    samples: Annotated[int, typer.Option("--samples", help="The samples of traced paths.", min=1)] = 128,
) -> None:
    """Compare how bright hair is in pictures of normal and of high quality."""
    print_brightness(tuple(sources), color, side, samples)


@study.command()
def banner(
    demo: Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder that fastlines demo wrote.")] = Path(
        "fastlines-demo"
    ),
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.png")] = Path("docs/images/banner.png"),
) -> None:
    """Compose the README's banner from the pictures of a demo."""
    make_banner(demo, output)
