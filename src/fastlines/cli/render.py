"""``fastlines render``: draw lines, or the levels of a tree."""

from __future__ import annotations

from typing import Annotated

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
        str, Option("--output", "-o", metavar="FILE", help="The picture: a .png for the eye, or an .exr of numbers.")
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
            "attribute or '#rrggbb'.",
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
    pixel are drawn by the fraction of it that they cover. The samples end as soon as you press Ctrl-C, and the picture
    of those that are done is written.

    [bold]Examples[/]

    [cyan]fastlines render hair.tfx -o hair.png[/]

    [cyan]fastlines render hair.tfx --color blond --background '#334' --samples 64 -o blond.png[/]

    [cyan]fastlines render tracts.trk.gz --width 1920 --height 1080 -o tracts.png[/]

    [cyan]fastlines render streamlines.vtp --color speed --color-map magma -o speed.png[/]

    [cyan]fastlines render neuron.swc --background transparent -o neuron.png[/]

    [cyan]fastlines render scene:spaghetti --look depth --direction 0,-1,0 --up 0,0,1 -o top.png[/]

    [cyan]fastlines render hair.flt --radius 0.0005 -o hair.exr[/]

    [cyan]fastlines render hair.flt --radius 0.0005 --levels 6 -o levels.png[/]
    """
    from ..geometry import needs_radius
    from ..queries import require_radius
    from ..rendering import check_image_path, level_sheet, write_picture
    from ..rendering.depth import check_size
    from ..rendering.looks import Backdrop, make_look
    from ..rendering.looks.table import HAIR_COLORS
    from ..rendering.measures import MEASURES
    from ..rendering.radius import small, suitable_radius
    from .files import check_output, open_lines, show_progress
    from .hint import hint_at_radius

    extension = check_image_path(output)
    check_output(output)
    shading = {"--look": look, "--color": color, "--background": background, "--samples": samples}
    if levels:
        refuse_given({"--width": width, "--height": height, **shading}, "levels are drawn in panels of a fixed size")
        if extension != ".png":
            raise InputError(f"{output}: levels are drawn as .png")
    width, height = width or SIZE, height or SIZE
    check_size(width, height)
    if method is not None:
        method_settings(method)
    view, upwards = vector(direction, "--direction"), vector(up, "--up")
    is_transparent = background == "transparent"
    if is_transparent and extension == ".exr":
        raise InputError(f"{output}: an .exr is always transparent; leave out --background")
    if background is not None and not is_transparent:
        Backdrop.of(background)
    opened = open_lines(source, skip_invalid, format, option)
    if opened.tree is not None:
        refuse_given({"--method": method}, f"{source} is a tree already; 'fastlines build' makes another")
    is_measure = look in MEASURES
    if is_measure:
        refuse_given({"--color": color}, f"the look {look} has colours of its own")
    made = look if is_measure else make_look(look, opened.geometry, color, color_map, quality)
    if legend is None:
        legend = is_measure or ((color or "#")[0] != "#" and color not in (*HAIR_COLORS, "direction", "strand"))
    camera = opened.camera(view, upwards, fov, 1.0 if levels else width / height)
    progress = show_progress()
    tree = opened.tree or fl.build(opened.geometry, method or DEFAULT_METHOD, progress=progress)
    chosen = radius is None and needs_radius(opened.geometry)
    if chosen:
        radius = suitable_radius(tree, opened.camera())
        require_radius(opened.geometry, radius)
    radius = radius or 0.0
    if levels:
        write_picture(output, level_sheet(tree, camera, radius, levels, progress=progress))
    else:
        picture = fl.render(
            tree,
            camera,
            width=width,
            height=height,
            look=made,
            radius=radius,
            samples=samples,
            background=None if is_transparent else background,
            exposure=exposure,
            aovs=extension == ".exr",
            legend=legend,
            progress=progress,
        )
        picture.save(output, is_transparent)
        if not chosen:
            hint_at_radius(tree, *camera.rays(*small(width, height)), radius)
    what = f"{levels} levels" if levels else f"{width} × {height} pixels"
    typer.echo(f"{output}: {what}, {_thickness(tree, radius, chosen)}")


def _thickness(tree: Tree, radius: float, is_chosen: bool) -> str:
    """Say what was drawn, and how thick."""
    from ..geometry import count_text, parts_of
    from ..places import names

    geometry: AnyGeometry = tree.geometry
    is_thick = any("radius" in names(part) for part in parts_of(geometry))
    own = ", and their own" if is_thick else ", which suits them; --radius sets another" if is_chosen else ""
    return f"{count_text(geometry)}, radius {radius:g}{own}"
