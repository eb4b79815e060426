"""``fastlines render``: draw lines, or the levels of a tree."""

from __future__ import annotations

from typing import Annotated

import typer
from typer import Option

from ..errors import InputError
from .options import (
    AskedInput,
    Direction,
    Focus,
    FormatName,
    FormatOptions,
    Fov,
    Lens,
    Memory,
    OwnRadius,
    PictureRadius,
    Scheduler,
    Skip,
    Up,
    refuse_given,
    vector,
)

#: The width and the height of a square picture in pixels.
SIZE = 1024
#: The same of a preview.
PREVIEW_SIZE = 256
WITHOUT_SIZE = f"If neither is given, there are about {SIZE}² pixels, in an aspect ratio that suits the lines."


def render(
    source: AskedInput,
    output: Annotated[
        str,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="The picture: a .png for the eye, or an .exr of numbers. Many pictures: x.png for x_0001.png and so "
            "on, a .gif, or an .mp4 (needs the package imageio-ffmpeg).",
        ),
    ],
    look: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="hair, fibre, tube, depth, id, normal, tangent, hits, density or work; chosen by default.",
        ),
    ] = None,
    radius: PictureRadius = None,
    own_radius: OwnRadius = True,
    color: Annotated[
        str | None,
        Option(
            metavar="NAME",
            help="Of hair: white, blond, red, brown, black or '#rrggbb'. Of fibres and tubes: direction, strand, an "
            "attribute or '#rrggbb'; attribute:strand for an attribute of that name.",
        ),
    ] = None,
    color_map: Annotated[
        str | None,
        Option(metavar="NAME", help="For an attribute: viridis (default), magma, inferno, coolwarm or gray."),
    ] = None,
    material: Annotated[
        str | None,
        Option(metavar="NAME", help="Of fibres and tubes: matt, satin (default), polished or metal."),
    ] = None,
    variation: Annotated[
        float | None,
        Option(
            min=0.0,
            max=1.0,
            help="How much brighter or darker than the mean a strand is; by default 0.25 in hair, and else 0.",
        ),
    ] = None,
    background: Annotated[
        str | None, Option(metavar="COLOR", help="'#rrggbb', '#rrggbb:#rrggbb' from top to bottom, or transparent.")
    ] = None,
    ground: Annotated[
        bool | None,
        Option("--ground/--no-ground", help="Whether lines cast a shadow on the ground; by default tubes do."),
    ] = None,
    rig: Annotated[
        str | None, Option(metavar="NAME", help="The lights: studio, salon or soft; chosen by default.")
    ] = None,
    legend: Annotated[
        bool | None,
        Option(
            "--legend/--no-legend", help="Draw what colours mean; by default for attributes, hits, density and work."
        ),
    ] = None,
    legend_title: Annotated[
        str | None, Option(metavar="TEXT", help="The title of the legend, such as 'speed in m/s'.")
    ] = None,
    quality: Annotated[
        str, Option(metavar="NAME", help="normal, or high: trace the paths of light in hair; takes many samples.")
    ] = "normal",
    exposure: Annotated[float, Option(help="Multiply the light by 2 to this power.")] = 0.0,
    width: Annotated[int | None, Option(min=1, help=f"The picture's width in pixels. {WITHOUT_SIZE}")] = None,
    height: Annotated[int | None, Option(min=1, help=f"The picture's height in pixels. {WITHOUT_SIZE}")] = None,
    samples: Annotated[
        int | None,
        Option(
            "--samples",
            "-s",
            min=1,
            max=65536,
            help="How many samples a pixel; 16 by default, 4 for thin lines, 64 with a lens.",
        ),
    ] = None,
    preview: Annotated[
        bool, Option("--preview", help=f"Draw a quick picture: about {PREVIEW_SIZE}² pixels with one sample each.")
    ] = False,
    direction: Direction = None,
    up: Up = None,
    fov: Fov = None,
    lens_radius: Lens = None,
    focus_distance: Focus = None,
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
    memory: Memory = None,
    scheduler: Scheduler = None,
) -> None:
    """Render a picture of lines. For a file of lines or a scene, build a tree first.

    Without options, the look, the radius, the camera and the lights are chosen to suit the lines. Lines thinner than a
    pixel are drawn by the fraction of it that they cover. With [cyan]--preview[/], a quick small picture shows whether
    the view and the colours are right.

    A first picture is written early, and replaced every few seconds by one of more samples. A picture that takes more
    than a minute says how long, before it starts. Ctrl-C stops the samples, and writes the picture of those that are
    done. The same command with [cyan]--resume[/] goes on, and gives the picture of an uninterrupted run.

    [bold]Examples[/]

    [cyan]fastlines render hair.tfx -o hair.png[/]

    [cyan]fastlines render hair.tfx --preview -o quick.png[/]

    [cyan]fastlines render hair.tfx --color blond --background '#334' --samples 64 -o blond.png[/]

    [cyan]fastlines render tracts.trk.gz --width 1920 --height 1080 -o tracts.png[/]

    [cyan]fastlines render streamlines.vtp --color speed --color-map magma -o speed.png[/]

    [cyan]fastlines render wires.csv --look tube --radius 0.1 --material metal -o wires.png[/]

    [cyan]fastlines render neuron.swc --background transparent -o neuron.png[/]

    [cyan]fastlines render scene:spaghetti --look depth --direction 0,-1,0 --up 0,0,1 -o top.png[/]

    [cyan]fastlines render hair.flt --radius 0.0005 -o hair.exr[/]

    [cyan]fastlines render hair.flt --turntable 60 -o turn.gif[/]

    [cyan]fastlines render hair.flt --radius-sweep 0.0005:0.05:60 -o frames/radius.png[/]

    [cyan]fastlines render hair.flt --radius 0.0005 --levels 6 -o levels.png[/]
    """
    from pathlib import Path

    from ..rendering import ViewOptions
    from .pictures import Order, draw
    from .sequence import swept_radii

    if legend is False and legend_title is not None:
        raise InputError("--no-legend and --legend-title are both given; give one of them")
    if preview:
        size = {"--width": width, "--height": height, "--samples": samples}
        others = {"--quality": None if quality == "normal" else quality, "--resume": resume or None}
        why = "--preview draws a small picture with one sample a pixel; leave out --preview"
        refuse_given({**size, **others, "--levels": levels or None}, why)
        samples = 1
    file = Path(output).suffix.lower()
    view = ViewOptions(
        direction=vector(direction, "--direction"),
        up=vector(up, "--up"),
        fov_degrees=fov,
        lens_radius=lens_radius,
        focus_distance=focus_distance,
        turns=turntable is not None,
    )
    order = Order(
        source=source,
        output=output,
        look=look,
        radius=radius,
        color=color,
        color_map=color_map,
        material=material,
        variation=variation,
        ground=ground,
        rig=rig,
        background=None if background == "transparent" else background,
        transparent=background == "transparent",
        legend=legend if legend_title is None else legend_title,
        file=file,
        aovs=file == ".exr",
        quality=quality,
        exposure=exposure,
        width=width,
        height=height,
        side=PREVIEW_SIZE if preview else SIZE,
        samples=samples,
        camera=view,
        turntable=turntable,
        radii=() if radius_sweep is None else swept_radii(radius_sweep),
        seconds=seconds,
        resume=resume,
        levels=levels,
        method=method,
        skip_invalid=skip_invalid,
        format=format,
        option=option,
        own_radius=own_radius,
        memory=memory,
        scheduler=scheduler,
    )
    typer.echo(draw(order))
