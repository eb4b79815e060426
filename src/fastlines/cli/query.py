"""``fastlines query``: find what rays hit."""

from __future__ import annotations

import json
import time
from typing import Annotated, Any

import typer
from typer import Option

from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..query.ray_arguments import RayOptions
from ..support.texts import counted
from .array_files import numbers
from .options import (
    AskedInput,
    Direction,
    FormatName,
    FormatOptions,
    Fov,
    Json,
    Memory,
    OwnRadius,
    Radius,
    Scheduler,
    Skip,
    Up,
    finite,
    refuse_given,
    size,
    vector,
)
from .ray_files import read_rays

#: The choices of --kind, and the methods of a tree.
KINDS = {"first": "first_hit", "any": "any_hit", "all": "all_hits", "next": "next_hits", "count": "count_hits"}

#: The kinds that list several hits of each ray.
LISTS = ("all", "next")

#: Which kinds the options apply to that do not apply to all of them, and why not to the others.
ONLY = {
    "rank": (("next",), "only next chooses hits"),
    "merge": (("all",), "only all lists what can be merged"),
}


def query(
    source: AskedInput,
    rays: Annotated[
        str | None,
        typer.Argument(
            metavar="RAYS",
            help="An array (n, 6) in a .npy file, origins and directions (n, 3) in a .npz file, or the columns x, y, "
            "z, dx, dy and dz of a .parquet file.",
        ),
    ] = None,
    radius: Radius = None,
    own_radius: OwnRadius = True,
    kind: Annotated[str, Option("--kind", "-k", metavar="KIND", help="first, any, all, next or count.")] = "first",
    nearest: Annotated[int | None, Option(metavar="N", help="The number of hits of each ray, for --kind next.")] = None,
    rank: Annotated[
        str | None, Option(metavar="BY", help="Which hits come first, for next: by t (the default) or distance.")
    ] = None,
    output: Annotated[
        str | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Write the answer to this .npz file, that of rays in .parquet to a .parquet; else only print figures.",
        ),
    ] = None,
    camera: Annotated[
        str | None, Option(metavar="WxH", help="Trace a picture of this size, row by row, instead of RAYS.")
    ] = None,
    direction: Direction = None,
    up: Up = None,
    fov: Fov = None,
    t_min: Annotated[float, Option(help="The ray begins at this t, in units of its direction's length.")] = 0.0,
    t_max: Annotated[float, Option(help="The ray ends at this t.")] = float("inf"),
    spread: Annotated[
        float | None,
        Option(callback=finite, help="By how much the radius grows for each unit of length along the ray."),
    ] = None,
    at: Annotated[
        str | None,
        Option(
            metavar="WHERE",
            help="Take t at the closest approach (closest, the default) or the surface; with entry, rays hit only what "
            "they come into from outside.",
        ),
    ] = None,
    merge: Annotated[
        str | None,
        Option(metavar="strand", help="Make one hit of those of a strand that overlap; for all, with --at surface."),
    ] = None,
    ignore: Annotated[
        str | None,
        Option(
            metavar="N,N,…",
            help="Primitives to leave out: their numbers, or a .npy file, (k,) for all rays or (n, m) for each.",
        ),
    ] = None,
    ignore_strands: Annotated[str | None, Option(metavar="N,N,…", help="Strands to leave out, likewise.")] = None,
    parts: Annotated[str | None, Option(metavar="N,N,…", help="The parts that rays see, of a tree of several.")] = None,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
    memory: Memory = None,
    scheduler: Scheduler = None,
    as_json: Json = False,
) -> None:
    r"""Find what rays hit, with any radius, and write the answer as arrays.

    For a file of lines or a scene, build a tree first; [cyan]fastlines build[/] keeps one for many queries.

    For the kinds first, all and next the file has the arrays t, prim, u and distance. For all and next it also has
    offsets: the hits of ray i are those from offsets\[i] to offsets\[i + 1]. For any it has hit, for count count.
    If rows of the input were skipped when the tree was built, row is the row of each prim in the input. If the lines
    have strands, strand is the strand of each prim. prim, row and strand are -1 for a miss.

    Rays in a .parquet file are read, and their hits written, a million rays at a time; the hits are rows there.

    If less than 1 % of the rays that cross the box of the lines hit, a note on stderr names a radius with which a
    quarter of them would.

    [bold]Examples[/]

    [cyan]fastlines query hair.flt rays.npy --radius 0.001 -o hits.npz[/]

    [cyan]fastlines query hair.tfx rays.npz --radius 0.001 --kind all -o hits.npz[/]

    [cyan]fastlines query hair.flt rays.npz --radius 0.01 --kind next --nearest 4 --rank distance -o hits.npz[/]

    [cyan]fastlines query neuron.swc rays.npy --kind all --at surface --merge strand -o hits.npz[/]

    [cyan]fastlines query hair.flt --camera 640x480 --radius 0.001 --kind count[/]

    [cyan]fastlines query cohort.forest rays.npy --radius 0.1 --scheduler local -o hits.npz[/]

    [cyan]fastlines query cohort.forest rays.parquet --radius 0.1 --kind all -o hits.parquet[/]
    """
    from ..forest.mapping.parquet import query_parquet
    from ..query.rays import require_radius
    from ..rendering import ViewOptions
    from ..rendering.shading.depth import check_size
    from .files import check_output, open_input, placed, show_progress, tree_of, write_npz
    from .hint import hint_at_radius

    in_parquet = rays is not None and rays.lower().endswith(".parquet")
    check_output(output, ".parquet" if in_parquet else ".npz", inputs=(source, rays))
    if kind not in KINDS:
        raise InputError(f"--kind {kind!r} is not a choice: use one of {', '.join(KINDS)}")
    if (rays is None) == (camera is None):
        raise InputError("give the rays either as a file or by --camera, such as --camera 640x480")
    if (kind == "next") != (nearest is not None):
        raise InputError("--kind next and --nearest go together: give the number of hits, such as --nearest 4")
    only: dict[str, Any] = {"rank": rank, "merge": merge}
    for name, value in only.items():
        kinds, why = ONLY[name]
        if kind not in kinds:
            refuse_given({f"--{name}": value}, f"this is --kind {kind}, and {why}")
    if camera is None:
        looks = {"--direction": direction, "--up": up, "--fov": fov}
        refuse_given(looks, "the rays come from a file, not from a camera")
    # The options of all queries, as `RayOptions` names them.
    ray_options: RayOptions = {
        "t_min": t_min,
        "t_max": t_max,
        "spread": spread or 0.0,
        "ignore": numbers(ignore, "--ignore"),
        "ignore_strands": numbers(ignore_strands, "--ignore-strands"),
        "parts": numbers(parts, "--parts"),
        "progress": show_progress(),
    }

    opened = open_input(source, skip_invalid, format, option, own_radius, forests=True)
    seen = None if ray_options["parts"] is None else opened.geometry.check_parts(ray_options["parts"])
    require_radius(opened.geometry, radius, spread or 0.0, seen)
    radius = radius or 0.0
    given = {name: value for name, value in (only | {"at": at, "k": nearest}).items() if value is not None}
    if in_parquet:
        if output is None:
            raise InputError(
                f"{rays}: the hits of rays in .parquet go to a file; name it by -o, such as -o hits.parquet"
            )
        with placed(opened, memory, scheduler) as asked:
            tree = tree_of(asked)
            start = time.perf_counter()
            asked_for: Any = KINDS[kind]
            n_rays = query_parquet(tree, str(rays), output, asked_for, radius, **given, **ray_options)
            seconds = time.perf_counter() - start
        facts = {"n_rays": n_rays, "kind": kind, "radius": radius, "seconds": seconds, "output": output}
        text = f"{output}: {counted(n_rays, 'rays')}, in {seconds:.3f} s"
        typer.echo(json.dumps(facts, indent=2) if as_json else text)
        return
    if camera is not None:
        width, height = size(camera, "--camera")
        check_size(width, height)
        view = ViewOptions(vector(direction, "--direction"), vector(up, "--up"), fov)
        origins, directions = view.camera(opened.geometry, width / height).rays(width, height)
    else:
        origins, directions = read_rays(str(rays))
    with placed(opened, memory, scheduler) as asked:
        tree = tree_of(asked)
        start = time.perf_counter()
        answer = getattr(tree, KINDS[kind])(origins, directions, radius, **given, **ray_options)
        seconds = time.perf_counter() - start

        # Write the arrays, and report counts and time.
        if output is not None:
            write_npz(output, **_arrays(kind, answer, tree.geometry))
        if not (spread or ignore or ignore_strands):
            hint_at_radius(tree, origins, directions, radius, seen, t_min=t_min, t_max=t_max)
    n_rays, n_found = len(directions), _count(kind, answer)
    if as_json:
        what = "n_hits" if kind in (*LISTS, "count") else "n_rays_that_hit"
        found_facts = {"n_rays": n_rays, "kind": kind, "radius": radius, what: n_found}
        typer.echo(json.dumps({**found_facts, "seconds": seconds, "output": output}, indent=2))
        return
    found = counted(n_found, "hits") if kind in (*LISTS, "count") else f"{n_found:,} of them hit something"
    rate = f", {n_rays / seconds / 1e6:.3g} million rays a second" if n_rays else ""
    typer.echo(f"{output or opened.name}: {counted(n_rays, 'rays')}, {found}, in {seconds:.3f} s{rate}")


def _arrays(kind: str, answer: Any, geometry: AnyGeometry) -> dict[str, Any]:
    """Return the arrays of an answer by their names in the file."""
    if kind in ("any", "count"):
        return {"hit" if kind == "any" else "count": answer}
    names = ["t", "prim", "u", "distance"]
    names += ["offsets"] * (kind in LISTS) + ["t_out"] * (answer.t_out is not None)
    names += ["part"] * (answer.part is not None)
    names += ["row"] * (geometry.n_skipped > 0)
    names += ["strand"] * (geometry.n_strands > 0)
    return {name: getattr(answer, name) for name in names}


def _count(kind: str, answer: Any) -> int:
    """Return the number of hits, or of rays that hit."""
    if kind == "first":
        return int(answer.hit.sum())
    return len(answer) if kind in LISTS else int(answer.sum())
