"""``fastlines beams``: the light that fog, smoke or water scatters, from photon beams."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Option

from ..errors import InputError
from ..progress import reporting, staged
from ..support.texts import counted
from .files import check_output, note, show_progress
from .resume import WRITE_SECONDS, check_resume, keep_state, state_path, without_interrupts

if TYPE_CHECKING:
    from ..beams import BeamScene, Passes
    from ..rendering import Pace

SIZE = 512  # as in `PassSettings`


def beams(
    scene: Annotated[
        str, typer.Argument(metavar="SCENE", help="A built-in scene: mirrored-cube, glass-sphere or point-light.")
    ],
    output: Annotated[
        str,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Write an .exr of the radiance, its variance and the number of samples, or a .png for the eye.",
        ),
    ],
    width: Annotated[int | None, Option(min=1, help=f"The width in pixels; the height, or {SIZE}, by default.")] = None,
    height: Annotated[
        int | None, Option(min=1, help=f"The height in pixels; the width, or {SIZE}, by default.")
    ] = None,
    passes: Annotated[
        int,
        Option(
            min=1, help="How many passes to average, each of new photons; with --resume, those that are done count."
        ),
    ] = 16,
    paths: Annotated[int, Option(min=1, help="How many photons each pass emits.")] = 50_000,
    radius: Annotated[
        float | None,
        Option(
            "--radius",
            "-r",
            help="The radius of the blur in the first pass, in the unit of the scene; by default 1/200 of its size.",
            show_default=False,
        ),
    ] = None,
    alpha: Annotated[float, Option(help="How slowly the radius shrinks from pass to pass; 1 keeps it.")] = 0.7,
    long: Annotated[
        bool, Option("--long", help="Make beams that end at surfaces, rather than where photons collide.")
    ] = False,
    adapt: Annotated[
        bool, Option("--adapt", help="Give each beam a radius that suits how dense beams are around it.")
    ] = False,
    blur: Annotated[str, Option(metavar="NAME", help="The kernel of the blur: box or epanechnikov.")] = "box",
    estimator: Annotated[
        str, Option(metavar="NAME", help="Gather the beams that rays cross (beam), or those near points (point).")
    ] = "beam",
    seed: Annotated[int, Option(min=0, help="Another number gives other photons.")] = 0,
    exposure: Annotated[
        float | None,
        Option(help="Multiply the light of a .png by 2 to this power; chosen by default.", show_default=False),
    ] = None,
    method: Annotated[str, Option("--method", "-m", metavar="NAME", help="The kind of tree to build.")] = "beams",
    resume: Annotated[
        bool, Option("--resume", help="Go on with a picture that Ctrl-C has stopped, but not with a finished one.")
    ] = False,
) -> None:
    """Render the light that a medium scatters, from the flights of photons: fog, caustics, shafts of light.

    Each pass traces new photons, builds a tree over their flights, and gathers their light with a smaller radius. Every
    few seconds, the passes so far are saved beside the picture, and a .png is replaced. Ctrl-C writes the picture of
    the passes that are done. The same command with [cyan]--resume[/] goes on, after a crash too, and gives the picture
    of an uninterrupted run.

    [bold]Examples[/]

    [cyan]fastlines beams glass-sphere -o caustic.exr[/]

    [cyan]fastlines beams mirrored-cube --passes 64 --width 1024 -o cube.png[/]

    [cyan]fastlines beams point-light --radius 0.01 --alpha 1 -o light.png[/]
    """
    from ..beams import Passes
    from ..beams.beam_picture import check_picture_file
    from ..rendering import Pace

    is_png = check_picture_file(output, exposure) == ".png"
    check_output(output)
    check_resume(output, resume)
    made = Passes(
        _scene(scene),
        width=width,
        height=height,
        n_paths=paths,
        radius=radius,
        alpha=alpha,
        kind="long" if long else "short",
        adapt=adapt,
        blur=blur,
        estimator=estimator,
        seed=seed,
        method=method,
    )
    if resume:
        _go_on(made, passes, state_path(output))
    else:
        _warn_of_saved(state_path(output))

    def keep() -> None:
        made.save(state_path(output))
        if is_png:
            made.picture().save(output, exposure)

    pace = Pace(WRITE_SECONDS)
    is_whole = _add_passes(made, passes, pace, keep)
    if not made.done:
        typer.echo("stopped in the first pass, so there is no picture yet, and nothing was written", err=True)
        raise typer.Exit(130)
    picture = made.picture()
    with without_interrupts():
        picture.save(output, exposure)
        done = f"{made.done} of {counted(passes, 'passes')}"
        keep_state(made, output, is_whole, resume or pace.n_shown > 0, done)
    shown = f", exposure {picture.exposure if exposure is None else exposure:.3g}" if is_png else ""
    typer.echo(f"{output}: {counted(picture.n_passes, 'passes')}, {counted(picture.n_paths, 'photons')}{shown}")


def _scene(name: str) -> BeamScene:
    """Return a built-in scene; say where others are rendered if a file is given."""
    from ..beams import NAMES, example

    if name not in NAMES and Path(name).suffix:
        raise InputError(
            f"{name}: a scene of your own is rendered in Python, by fl.beams.render(scene).save(path); the built-in "
            f"ones are {', '.join(NAMES)}"
        )
    return example(name)


def _go_on(made: Passes, n_passes: int, state: str) -> None:
    """Take over the passes of a state, if there are not too many."""
    made.resume(state)
    if made.done > n_passes:
        raise InputError(
            f"{state}: {made.done} passes are done; --passes {n_passes} counts them too: give --passes {made.done} or "
            "more, or leave out --resume to render from the start"
        )


def _warn_of_saved(state: str) -> None:
    """Say that passes of an unfinished picture will be replaced."""
    from ..beams.passes import count_saved

    if n_saved := count_saved(state):
        note(
            f"{state}: has {counted(n_saved, 'passes')} of an unfinished picture, which new ones replace; --resume "
            "goes on from them"
        )


def _add_passes(made: Passes, n_passes: int, pace: Pace, keep: Callable[[], object]) -> bool:
    """Add passes until there are enough or until Ctrl-C; return whether all are there.

    `keep` writes what is done. It is called every few seconds if the passes take long.
    """
    from ..rendering import report_if_long

    is_reported = False
    with reporting(show_progress(), "render") as callback:
        try:
            while made.done < n_passes:
                made.add(staged(callback, made.done / n_passes, (made.done + 1) / n_passes))
                left = (made.seconds_a_pass or 0.0) * (n_passes - made.done)
                if not is_reported:
                    report_if_long("this picture takes", left, note)
                    is_reported = True
                pace.show(left, keep)
        except KeyboardInterrupt:
            return False
    return True
