"""``fastlines-bench hair``: the scattering of hair beside Mitsuba's."""

from __future__ import annotations

from typing import Annotated

import typer

from ..studies.scattering.run import HairPreset, run_hair
from ..studies.scattering.show import print_hair
from .app import app
from .options import JsonFile, Quick, check_files, progress_bar, write_json


@app.command(short_help="The scattering of hair beside Mitsuba's: relative errors.")
def hair(
    pairs: Annotated[
        int | None,
        typer.Option(
            "--pairs",
            "-n",
            help="The number of pairs of directions for each material; the default is 100,000.",
            min=10,
            show_default=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="The seed of the random directions.", min=0)] = 0,
    quick: Quick = False,
    json_file: JsonFile = None,
    examples: Annotated[
        str | None,
        typer.Option(
            "--examples",
            metavar="FILE.json",
            help="Write a few of Mitsuba's values to this file. The tests of fastlines have such a file.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Evaluate six materials by fastlines and by Mitsuba 3 (pip install mitsuba), and report the relative errors.

    [bold]Examples[/]

    [cyan]fastlines-bench hair --quick[/]

    [cyan]fastlines-bench hair --json hair.json[/]  half a minute

    [cyan]fastlines-bench hair --quick --examples mitsuba_hair.json[/]
    """
    check_files(json_file)
    check_files(examples)
    with progress_bar() as progress:
        result = run_hair(HairPreset.of(quick, n_pairs=pairs, seed=seed), progress)
    print_hair(result)
    write_json(json_file, result.to_json())
    write_json(examples, {"mitsuba": result.mitsuba, "examples": result.examples} if examples else None)
