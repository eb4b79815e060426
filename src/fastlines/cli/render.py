"""``fastlines render``: draw lines, or the levels of a tree."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Option

import fastlines as fl

from ..errors import InputError
from ..geometry import AnyGeometry
from ..methods import DEFAULT_METHOD, method_settings
from ..tree import Tree
from .app import app
from .options import Direction, FormatName, FormatOptions, Fov, Input, Radius, Skip, Up, refuse_given, vector

#: Width and height of a picture in pixels.
SIZE = 1024


@app.command(short_help="Render lines: hair, fibres, tubes; or draw the levels of a tree.")
def render(
    source: Input,
    output: Annotated[
        str,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="The picture: a .png for the eye, or an .exr of numbers. Many pictures: x.png for x_0001.png and so "
            "on, a .gif, or an .mp4 (needs the extra video).",
        ),
    ],
    look: Annotated[
        str | None,
        Option(metavar="NAME", help="hair, fibre, tube, depth, id, normal, tangent, hits or work; chosen by default."),
    ] = None,
    radius: Radius = None,
    color: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="Of hair: white, blond, red, brown, black or '#rrggbb'. Of fibres and tubes: direction, strand, an "
            "attribute or '#rrggbb'; attribute:strand for an attribute of that name.",
        ),
    ] = None,
    color_map: Annotated[
        str, Option(metavar="NAME", help="For an attribute: viridis, magma, inferno, coolwarm or gray.")
    ] = "viridis",
    background: Annotated[
        str | None, Option(metavar="COLOR", help="'#rrggbb', '#rrggbb:#rrggbb' from top to bottom, or transparent.")
    ] = None,
    legend: Annotated[
        bool | None,
        Option("--legend/--no-legend", help="Draw what colours mean; by default for attributes, hits and work."),
    ] = None,
    quality: Annotated[
        str, Option(metavar="NAME", help="normal, or high: trace the paths of light in hair; takes many samples.")
    ] = "normal",
    exposure: Annotated[float, Option(help="Multiply the light by 2 to this power.")] = 0.0,
    width: Annotated[int | None, Option(min=1, help=f"The picture's width in pixels; {SIZE} by default.")] = None,
    height: Annotated[int | None, Option(min=1, help=f"The picture's height in pixels; {SIZE} by default.")] = None,
    samples: Annotated[
        int | None,
        Option(
            "--samples",
            "-s",
            min=1,
            max=65536,
            help="How many samples a pixel; 16 by default, 4 for thin lines.",
        ),
    ] = None,
    direction: Direction = None,
    up: Up = None,
    fov: Fov = None,
    turntable: Annotated[
        int | None, Option(min=1, max=100000, metavar="N", help="Write this many pictures of a turn around the lines.")
    ] = None,
    radius_sweep: Annotated[
        str | None,
        Option(
            metavar="A:B:N",
            help="Write N pictures with radii from A to B, each the same factor larger; if A or B is 0, the same step.",
        ),
    ] = None,
    seconds: Annotated[
        float | None, Option(help="How long a .gif or .mp4 shows each picture; 0.04 by default.")
    ] = None,
    resume: Annotated[bool, Option("--resume", help="Go on with a picture that Ctrl-C has stopped.")] = False,
    levels: Annotated[int, Option(min=0, max=64, help="Draw the boxes of this many levels of the tree instead.")] = 0,
    method: Annotated[
        str | None, Option("--method", "-m", metavar="NAME", help="The kind of tree to build; best by default.")
    ] = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
) -> None:
    """Render a picture of lines. For a file of lines or a scene, build a tree first.

    Without options, the look, the radius, the camera and the lights are chosen to suit the lines. Lines thinner than a
    pixel are drawn by the fraction of it that they cover. Ctrl-C stops the samples, and writes the picture of those
    that are done. The same command with [cyan]--resume[/] goes on, and gives the picture of an uninterrupted run.

    [bold]Examples[/]

    [cyan]fastlines render hair.tfx -o hair.png[/]

    [cyan]fastlines render hair.tfx --color blond --background '#334' --samples 64 -o blond.png[/]

    [cyan]fastlines render tracts.trk.gz --width 1920 --height 1080 -o tracts.png[/]

    [cyan]fastlines render streamlines.vtp --color speed --color-map magma -o speed.png[/]

    [cyan]fastlines render neuron.swc --background transparent -o neuron.png[/]

    [cyan]fastlines render scene:spaghetti --look depth --direction 0,-1,0 --up 0,0,1 -o top.png[/]

    [cyan]fastlines render hair.flt --radius 0.0005 -o hair.exr[/]

    [cyan]fastlines render hair.flt --turntable 60 -o turn.gif[/]

    [cyan]fastlines render hair.flt --radius-sweep 0.0005:0.05:60 -o frames/radius.png[/]

    [cyan]fastlines render hair.flt --radius 0.0005 --levels 6 -o levels.png[/]
    """
    from ..geometry import needs_radius
    from ..queries import require_radius
    from ..rendering import MEASURES, check_image_path, finish, level_sheet, renderer_of, write_picture
    from ..rendering.depth import check_size
    from ..rendering.frames import SECONDS
    from ..rendering.looks import Backdrop, make_look
    from ..rendering.looks.solid import Solid
    from ..rendering.radius import small, suitable_radius
    from ..rendering.renderer import check_exposure
    from .files import check_output, open_lines, show_progress
    from .hint import hint_at_radius
    from .sequence import check_sequence, write_sequence
    from .unfinished import add_samples, check_resume, keep_state

    is_sequence = turntable is not None or radius_sweep is not None
    radii: list[float] = []
    if is_sequence:
        alone: dict[str, object] = {"--levels": levels or None, "--resume": resume or None}
        alone |= {} if radius_sweep is None else {"--radius": radius}
        radii = check_sequence(output, radius_sweep, turntable, alone)
        extension = Path(output).suffix.lower()
    else:
        extension = check_image_path(output)
        check_output(output)
        refuse_given({"--seconds": seconds}, "it is for --turntable and --radius-sweep")
        check_resume(output, resume)
    going_on = {"--resume": resume or None}
    shading = {"--look": look, "--color": color, "--background": background, "--samples": samples, **going_on}
    if levels:
        refuse_given({"--width": width, "--height": height, **shading}, "levels are drawn in panels of a fixed size")
        if extension != ".png":
            raise InputError(f"{output}: levels are drawn as .png")
    width, height = width or SIZE, height or SIZE
    check_size(width, height)
    if method is not None:
        method_settings(method)
    view, upwards = vector(direction, "--direction"), vector(up, "--up")
    check_exposure(exposure)
    is_transparent = background == "transparent"
    if is_transparent and extension == ".exr":
        raise InputError(f"{output}: an .exr is always transparent; leave out --background")
    backdrop = None if background is None or is_transparent else Backdrop.of(background)
    opened = open_lines(source, skip_invalid, format, option)
    if opened.tree is not None:
        refuse_given({"--method": method}, f"{source} is a tree already; 'fastlines build' makes another")
    is_measure = look in MEASURES
    if is_measure:
        high = quality if quality != "normal" else None
        refuse_given({"--color": color, "--quality": high}, f"the look {look} has colours of its own")
    made = MEASURES[str(look)] if is_measure else make_look(look, opened.geometry, color, color_map, quality)
    if legend is None:
        legend = is_measure or (isinstance(made, Solid) and made.color.has_bar(opened.geometry))
    camera = opened.camera(view, upwards, fov, 1.0 if levels else width / height, turntable is not None)
    progress = show_progress()
    tree = opened.tree or fl.build(opened.geometry, method or DEFAULT_METHOD, progress=progress)
    chosen = radius is None and not radii and needs_radius(opened.geometry)
    if chosen:
        radius = suitable_radius(tree, opened.camera())
        require_radius(opened.geometry, radius)
    radius = radius or 0.0
    if levels:
        write_picture(output, level_sheet(tree, camera, radius, levels, progress=progress))
        typer.echo(f"{output}: {levels} levels, {_thickness(tree, radius, chosen)}")
        return
    shown: dict[str, Any] = {"exposure": exposure, "aovs": extension == ".exr", "legend": legend}
    drawn: dict[str, Any] = {"width": width, "height": height, "radius": radius}
    if is_sequence:
        options = (
            drawn | shown | {"look": made, "samples": samples, "background": None if is_transparent else background}
        )
        frame_seconds = SECONDS if seconds is None else seconds
        what = write_sequence(
            output, tree, camera, radii, turntable, frame_seconds, progress, is_transparent, **options
        )
        thickness = f"radii {radii[0]:g} to {radii[-1]:g}" if radii else _thickness(tree, radius, chosen)
        typer.echo(f"{what}, {thickness}")
        return
    renderer = renderer_of(tree, camera, width, height, radius, made, backdrop, None, samples)
    is_whole = add_samples(renderer, output, resume, progress)
    if renderer.n_rows:  # else an older picture of this name is better
        finish(renderer, backdrop, **shown).save(output, is_transparent)
    keep_state(renderer, output, is_whole, resume)
    if not chosen:
        hint_at_radius(tree, *camera.rays(*small(width, height)), radius)
    typer.echo(f"{output}: {width} × {height} pixels, {_thickness(tree, radius, chosen)}")


def _thickness(tree: Tree, radius: float, is_chosen: bool) -> str:
    """Say what was drawn, and how thick."""
    from ..geometry import count_text, parts_of
    from ..places import names

    geometry: AnyGeometry = tree.geometry
    is_thick = any("radius" in names(part) for part in parts_of(geometry))
    own = ", and their own" if is_thick else ", which suits them; --radius sets another" if is_chosen else ""
    return f"{count_text(geometry)}, radius {radius:g}{own}"
