"""``fastlines render``: draw lines, or the levels of a tree."""

from __future__ import annotations

from typing import Annotated

import typer
from typer import Option

import fastlines as fl

from ..errors import InputError
from ..methods import DEFAULT_METHOD, method_settings
from .app import app
from .options import Direction, FormatName, FormatOptions, Fov, Input, Radius, Skip, Up, refuse_given, vector


@app.command(short_help="Draw lines by depth, or the levels of a tree.")
def render(
    source: Input,
    output: Annotated[
        str, Option("--output", "-o", metavar="FILE", help="The picture: a .png for the eye, or an .exr of depths.")
    ],
    radius: Radius = None,
    width: Annotated[int | None, Option(min=1, help="The picture's width in pixels; 800 by default.")] = None,
    height: Annotated[int | None, Option(min=1, help="The picture's height in pixels; 800 by default.")] = None,
    direction: Direction = None,
    up: Up = None,
    fov: Fov = None,
    samples: Annotated[
        int | None, Option(min=1, max=16, help="Average this many by this many rays a pixel of a PNG; 3 by default.")
    ] = None,
    levels: Annotated[int, Option(min=0, max=64, help="Draw the boxes of this many levels of the tree instead.")] = 0,
    method: Annotated[
        str | None, Option("--method", "-m", metavar="NAME", help="The kind of tree to build; best by default.")
    ] = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
) -> None:
    """Draw lines by depth: lighter is nearer. For a file of lines or a scene, build a tree first.

    Lines much thinner than a pixel are drawn by the fraction of it that they cover, and the picture is made lighter. An
    .exr has one ray a pixel. If less than 1 % of the rays that cross the box of the lines hit, a note on stderr names a
    radius with which a quarter of them would.

    [bold]Examples[/]

    [cyan]fastlines render hair.flt --radius 0.0005 -o hair.png[/]

    [cyan]fastlines render thick.hair -o thick.png[/]

    [cyan]fastlines render hair.tfx --radius 0.0005 --width 1920 --height 1080 -o hair.exr[/]

    [cyan]fastlines render scene:spaghetti --radius 0.001 --direction 0,-1,0 --up 0,0,1 -o top.png[/]

    [cyan]fastlines render hair.flt --radius 0.0005 --levels 6 -o levels.png[/]
    """
    from ..geometry import count_text, parts_of
    from ..places import names
    from ..queries import require_radius
    from ..rendering import check_image_path, depth_image, depth_picture, level_sheet, write_depth, write_picture
    from ..rendering.depth import check_size
    from ..rendering.radius import small
    from .files import check_output, open_lines, show_progress
    from .hint import hint_at_radius

    extension = check_image_path(output)
    check_output(output)
    size = {"--width": width, "--height": height, "--samples": samples}
    if levels:
        refuse_given(size, "levels are drawn in panels of a fixed size")
    if extension == ".exr":
        refuse_given({"--samples": samples}, "an .exr holds the depth of one ray a pixel")
    width, height = width or 800, height or 800
    check_size(width, height)
    if method is not None:
        method_settings(method)
    look, upwards = vector(direction, "--direction"), vector(up, "--up")
    if levels and extension != ".png":
        raise InputError(f"{output}: levels are drawn as .png")
    opened = open_lines(source, skip_invalid, format, option)
    if opened.tree is not None:
        refuse_given({"--method": method}, f"{source} is a tree already; 'fastlines build' makes another")
    require_radius(opened.geometry, radius)
    radius = radius or 0.0
    camera = opened.camera(look, upwards, fov, 1.0 if levels else width / height)
    progress = show_progress()
    tree = opened.tree or fl.build(opened.geometry, method or DEFAULT_METHOD, progress=progress)
    if levels:
        write_picture(output, level_sheet(tree, camera, radius, levels, progress=progress))
    elif extension == ".png":
        write_picture(output, depth_picture(tree, camera, width, height, radius, samples or 3, progress))
    else:
        write_depth(output, depth_image(tree, camera, width, height, radius, progress))
        hint_at_radius(tree, *camera.rays(*small(width, height)), radius)
    what = f"{levels} levels" if levels else f"{width} × {height} pixels"
    is_thick = any("radius" in names(part) for part in parts_of(opened.geometry))
    own = ", and their own" if is_thick else ""
    typer.echo(f"{output}: {what}, {count_text(opened.geometry)}, radius {radius:g}{own}")
