"""``fastlines scene`` and ``fastlines build``: make lines, and build a tree over lines."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Option

import fastlines as fl

from ..settings.methods import best_effort, method_settings
from ..settings.settings import limit_notes
from ..support.texts import bytes_text, counted
from .options import Effort, FormatName, FormatOptions, Input, Json, Method, Skip, n_bytes

if TYPE_CHECKING:
    from .files import Source


def scene(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="The scene to make; by default all are listed.")
    ] = None,
    output: Annotated[
        str | None, Option("--output", "-o", metavar="FILE.npz", help="The file to write; NAME.npz by default.")
    ] = None,
    n_segments: Annotated[
        int | None, Option("--segments", "-n", help="The number of segments; the thesis's number by default.")
    ] = None,
    seed: Annotated[int, Option("--seed", "-s", help="Another seed gives another scene of the same kind.")] = 0,
) -> None:
    """Make one of the five scenes of the thesis, as a file of lines.

    The file holds the arrays segments (n, 2, 3) and strands (n,); fl.read and all commands read it.

    [bold]Examples[/]

    [cyan]fastlines scene[/]  lists the scenes

    [cyan]fastlines scene spaghetti -o spaghetti.npz[/]

    [cyan]fastlines scene bun-hair -n 20000 --seed 7 -o hair.npz[/]
    """
    from .. import scenes
    from .files import check_output, write_npz

    if name is None:
        for known in scenes.NAMES:
            recipe = scenes.make(known)
            typer.echo(f"{known:<15}{len(recipe.lines):>7,} segments   {recipe.title}")
        return
    output = output or f"{name}.npz"
    check_output(output, ".npz")
    made = scenes.make(name, n_segments, seed)
    write_npz(output, segments=made.lines.segments, strands=made.lines.strands)
    typer.echo(f"{output}: {made.title}, {made.lines.count_text()}, {counted(made.lines.n_strands, 'strands')}")


def build(
    source: Input,
    method: Method = "best",
    output: Annotated[
        str | None,
        Option("--output", "-o", metavar="FILE.flt", help="Write the tree to this file; else only print figures."),
    ] = None,
    effort: Effort = None,
    c_trav: Annotated[float | None, Option(help="The cost of a step to a node.")] = None,
    c_prim: Annotated[float | None, Option(help="The cost of a test of a segment.")] = None,
    max_depth: Annotated[int | None, Option(help="No node is deeper than this level.")] = None,
    max_refs: Annotated[int | None, Option(help="The tree has at most this many references.")] = None,
    max_bytes: Annotated[
        str | None,
        Option(
            metavar="SIZE",
            help="The build takes at most this memory beside its input (best; grids of planes): bytes, 500MB, 4GiB.",
        ),
    ] = None,
    max_leaf_refs: Annotated[int | None, Option(help="No leaf has more references (BVHs only).")] = None,
    own_radius: Annotated[
        bool, Option("--own-radius/--no-own-radius", help="Whether the tree keeps the radius that lines have.")
    ] = True,
    dry_run: Annotated[
        bool, Option("--dry-run", help="Build only samples; print what the build will take, and write no file.")
    ] = False,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
    as_json: Json = False,
) -> None:
    """Build a tree over lines and save it in a file.

    With [cyan]--dry-run[/] it prints the expected number of references, the time, and the memory of tree, build and
    layout, beside the input: by samples of the lines, which are built on this machine. The time is right to a factor of
    about two.

    [bold]Examples[/]

    [cyan]fastlines build hair.tfx -o hair.flt[/]

    [cyan]fastlines build tracts.trk.gz --method kd-d2 -o tracts.flt[/]

    [cyan]fastlines build tracts.trk.gz --dry-run[/]  what that will take

    [cyan]fastlines build groom.usd -o groom.flt[/]  keeps cubic curves as curves

    [cyan]fastlines build scene:spaghetti --method bvh-cl[/]  prints the figures only

    [cyan]fastlines build scene:spaghetti --c-trav 2 --effort 1[/]  builds the cheapest tree for this cost

    [cyan]fastlines build scene:spaghetti-2:4000 -m kd-d2 --c-trav 1.0 --max-refs 500000 -o s.flt[/]
    """
    from .files import TREE, check_output, open_lines, show_progress

    check_output(output, TREE)
    settings = method_settings(method)
    costs = {name: value for name, value in (("c_trav", c_trav), ("c_prim", c_prim)) if value is not None}
    memory = None if max_bytes is None else n_bytes(max_bytes, "--max-bytes")
    bounds = {"max_depth": max_depth, "max_refs": max_refs, "max_bytes": memory, "max_leaf_refs": max_leaf_refs}
    given: dict[str, Any] = {name: value for name, value in bounds.items() if value is not None}
    opened = open_lines(source, skip_invalid, format, option, own_radius)
    if dry_run:
        if effort is None and method == "best" and not costs:
            effort = best_effort(len(opened.geometry.build_data()[1]))
        more: dict[str, Any] = {"effort": effort, "cost": replace(settings.cost, **costs) if costs else None}
        of_samples = {name: value for name, value in given.items() if name in ("max_depth", "max_leaf_refs")}
        whole = fl.build([[[0, 0, 0], [1, 1, 1]]], method, limits=fl.Limits(**given) if given else None, **more)
        sample = partial(fl.build, method=method, limits=fl.Limits(**of_samples) if of_samples else None, **more)
        _print_forecast(opened, whole.settings, sample, as_json)
        return
    start = time.perf_counter()
    tree = fl.build(
        opened.geometry,
        method,
        cost=replace(settings.cost, **costs) if costs else None,
        limits=fl.Limits(**given) if given else None,
        effort=effort,
        progress=show_progress(),
    )
    seconds = time.perf_counter() - start
    if output is not None:
        tree.save(output)
    stats = tree.stats()
    if as_json:
        typer.echo(json.dumps({"input": source, "output": output, "seconds": seconds, **stats}, indent=2))
        return
    limits = "".join(f"; {said}" for said in limit_notes(tree.limits_hit))
    typer.echo(
        f"{output or opened.name}: {tree.method} over {opened.geometry.count_text()}: "
        f"{counted(tree.n_refs, 'references')}, {counted(tree.n_nodes, 'nodes')}, depth {stats['depth']}, "
        f"cost {stats['cost']:.6g}, {bytes_text(stats['memory_bytes'])}, built in {seconds:.2f} s{limits}"
    )


def _print_forecast(opened: Source, settings: fl.Settings, sample: Callable[[Any], fl.Tree], as_json: bool) -> None:
    """Print what a build with these settings will take."""
    from .dry_run import advice, forecast

    n_prims = len(opened.geometry.build_data()[1])
    facts = forecast(opened.geometry, settings, sample)
    tile = advice(n_prims, facts["n_refs"], settings)
    if as_json:
        typer.echo(json.dumps({"input": opened.name, "n_prims": n_prims, **facts}, indent=2))
        return
    seconds = "" if facts["seconds"] is None else f", about {facts['seconds']:.2g} s"
    typer.echo(
        f"{opened.name}: a tree over {opened.geometry.count_text()} will have about "
        f"{counted(facts['n_refs'], 'references')} and take {bytes_text(facts['tree_bytes'])}{seconds}\n"
        f"memory beside the input: {bytes_text(facts['build_peak_bytes'])} while it is built, "
        f"{bytes_text(facts['layout_peak_bytes'])} more than the tree while the layout for queries is made, and "
        f"{bytes_text(facts['layout_bytes'])} for that layout\n"
        f"a tile of a forest of such lines: {tile}"
    )
