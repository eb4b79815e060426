"""``fastlines-bench cuda``: the answers and the speed of queries on a GPU."""

from __future__ import annotations

from typing import Annotated

import typer

from fastlines import InputError
from fastlines.scenes import NAMES

from ..cuda.resources import ResourcesPreset, run_resources
from ..cuda.run import CudaPreset, run_cuda
from ..cuda.show import print_cuda, print_resources, print_variants
from ..cuda.variants import VariantsPreset, run_variants
from ..harness.internals import TUNING
from .app import app
from .options import JsonFile, NRays, Quick, Rounds, check_files, check_names, progress_bar, write_json

NSegments = Annotated[
    int | None,
    typer.Option("--n-segments", help="The segments of each scene that is timed.", min=1, show_default=False),
]
Variants = Annotated[
    list[str] | None,
    typer.Option(
        "--variant",
        metavar="NAME=N,…",
        help=f"A variant: macros of {', '.join(TUNING)}. Repeat for more; the default is a list of ten.",
        show_default=False,
    ),
]
Limit = Annotated[
    float | None,
    typer.Option("--limit", metavar="SECONDS", help="Begin no scene after so long.", min=0.0, show_default=False),
]


@app.command(short_help="The answers and the speed of queries on a GPU, beside the CPU.")
def cuda(
    scene: Annotated[
        list[str] | None,
        typer.Option("--scene", "-s", metavar="NAME,…", help="The scenes; the default is all.", show_default=False),
    ] = None,
    n_segments: NSegments = None,
    n_rays: NRays = None,
    rounds: Rounds = None,
    limit: Limit = None,
    tune: Annotated[
        list[str] | None,
        typer.Option(
            "--tune",
            metavar="NAME=N",
            help=f"A macro of the kernels: {', '.join(TUNING)}. Repeat for more; answers do not depend on it.",
            show_default=False,
        ),
    ] = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Compare all queries on a GPU with brute force, bit for bit, and time them beside our own kernels of the CPU.

    Needs a GPU and the extra "cuda" of fastlines. Exits with 1 if an answer differs.

    [bold]Examples[/]

    [cyan]fastlines-bench cuda --quick[/]

    [cyan]fastlines-bench cuda --json cuda.json[/]  all scenes, within ten minutes

    [cyan]fastlines-bench cuda --quick --tune FASTLINES_NODE_ROWS=1 --tune FASTLINES_BLOCK=64[/]
    """
    check_files(json_file)
    preset = CudaPreset.of(
        quick,
        scenes=check_names("--scene", "scene", scene, NAMES),
        n_segments=n_segments,
        n_rays=n_rays,
        rounds=rounds,
        limit=limit,
        tuning=TUNING | _macros("--tune", tune or []),
    )
    with progress_bar() as progress:
        result = run_cuda(preset, progress)
    print_cuda(result)
    write_json(json_file, result.to_json())
    if not result.agrees:
        raise typer.Exit(1)


@app.command("cuda-variants", short_help="The speed of variants of the kernels on a GPU.")
def cuda_variants(
    scene: Annotated[
        list[str] | None,
        typer.Option(
            "--scene", "-s", metavar="NAME,…", help="The scenes; the default is bun-hair.", show_default=False
        ),
    ] = None,
    variant: Variants = None,
    n_segments: NSegments = None,
    n_rays: NRays = None,
    rounds: Rounds = None,
    limit: Limit = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Time variants of the kernels on a GPU, in turn on the same rays. Answers are compared with those of the CPU.

    Needs a GPU and the extra "cuda" of fastlines. Exits with 1 if an answer differs.

    [bold]Examples[/]

    [cyan]fastlines-bench cuda-variants --json variants.json[/]

    [cyan]fastlines-bench cuda-variants --variant FASTLINES_GROUP=1 --variant FASTLINES_GROUP=16,FASTLINES_BLOCK=64[/]
    """
    check_files(json_file)
    preset = VariantsPreset.of(
        quick,
        scenes=check_names("--scene", "scene", scene, NAMES),
        variants=_variants(variant),
        n_segments=n_segments,
        n_rays=n_rays,
        rounds=rounds,
        limit=limit,
    )
    with progress_bar() as progress:
        result = run_variants(preset, progress)
    print_variants(result)
    write_json(json_file, result.to_json())
    if not result.agrees:
        raise typer.Exit(1)


@app.command("cuda-resources", short_help="The registers and the memory of variants of the kernels, without a GPU.")
def cuda_resources(
    variant: Variants = None,
    arch: Annotated[
        str | None, typer.Option("--arch", help="The architecture; the default is sm_90.", show_default=False)
    ] = None,
    stack: Annotated[
        int | None,
        typer.Option("--stack", help="The entries of a stack; the default is 64.", min=1, show_default=False),
    ] = None,
    quick: Quick = False,
    json_file: JsonFile = None,
) -> None:
    """Compile variants of the kernels for segments, and print what a thread needs. NVRTC does it without a GPU.

    Needs the extra "cuda" of fastlines.

    [bold]Examples[/]

    [cyan]fastlines-bench cuda-resources --arch sm_120[/]
    """
    check_files(json_file)
    preset = ResourcesPreset.of(quick, variants=_variants(variant), arch=arch, stack=stack)
    with progress_bar() as progress:
        result = run_resources(preset, progress)
    print_resources(result)
    write_json(json_file, result.to_json())


def _variants(texts: list[str] | None) -> tuple[dict[str, int], ...] | None:
    return tuple(_macros("--variant", text.split(",")) for text in texts) if texts else None


def _macros(option: str, texts: list[str]) -> dict[str, int]:
    found = {}
    for text in texts:
        name, _, value = text.partition("=")
        if name not in TUNING or not (value.isascii() and value.isdigit()):
            raise InputError(f"{option} {text!r} is not NAME=N with a name of {', '.join(TUNING)}")
        found[name] = int(value)
    return found
