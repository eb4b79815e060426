"""``fastlines info`` and ``fastlines validate``: what a file holds, and whether a tree satisfies the axioms."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Annotated, Any

import numpy as np
import typer
from typer import Option

import fastlines as fl

from ..errors import FastlinesError, InputError
from ..progress import reporting
from ..settings.build_memory import expected_refs
from ..settings.methods import best_settings
from ..settings.settings import limit_notes
from ..support.texts import bytes_text, counted
from ..tree import Tree
from .files import Source
from .installation import describe_installation, installation_text
from .options import FormatName, FormatOptions, Json, OptionalInput, OwnRadius, TreeFile, refuse_given

#: The most characters a line of a picture.
COLUMNS = 80
#: Of so many primitives everything is found, which takes a fraction of a second. Of more, what takes at most half the
#: time of a build, unless all is wanted.
QUICK = 1 << 16


def info(
    source: OptionalInput = None,
    picture: Annotated[bool, Option("--picture", "-p", help="Draw it, small, in the terminal.")] = False,
    full: Annotated[
        bool, Option("--full", help="Find the radius for pictures and the duplicates also of a large file.")
    ] = False,
    own_radius: OwnRadius = True,
    format: FormatName = None,
    option: FormatOptions = None,
    as_json: Json = False,
) -> None:
    """Describe a file: the number and size of its lines, their attributes, and their oddities.

    Without a file, describe the installation: its version, and the instruction sets that it is compiled for.

    Segments that hold NaN or Inf are left out and counted. The radius for pictures is the least of 1, 2, 5, 10 … with
    which dense lines look closed; lines with a radius of their own need none. It takes a tree, and of more than 65,536
    segments it is found with [cyan]--full[/] only. So are duplicates.

    [bold]Examples[/]

    [cyan]fastlines info hair.tfx[/]

    [cyan]fastlines info hair.flt --json[/]

    [cyan]fastlines info tracts.trk.gz --picture[/]

    [cyan]fastlines info protein.pdb --option model=2[/]

    [cyan]fastlines info scene:photon-beams:10000 --full[/]
    """
    from .files import as_map, open_input

    if picture and as_json:
        raise InputError("--picture does not apply to --json; give one of them")
    if source is None:
        given = {"--picture": picture or None, "--full": full or None, "--no-own-radius": None if own_radius else True}
        refuse_given({**given, "--format": format, "--option": option or None}, "there is no INPUT")
        installed = describe_installation()
        typer.echo(json.dumps(installed, indent=2) if as_json else installation_text(installed))
        return
    opened = open_input(source, True, format, option, own_radius)
    assert not isinstance(opened.tree, fl.Forest)  # which is refused
    is_quick = len(opened.geometry) > QUICK and not full
    facts: dict[str, Any] = {"name": opened.name, "format": opened.format and opened.format.description}
    about = facts[opened.geometry.heading] = opened.geometry.summary()
    if opened.tree is not None:
        facts["tree"] = opened.tree.stats()
    shown, tree, radius = opened, opened.tree, None
    with _steps(len(opened.geometry) > QUICK) as step:
        if not is_quick:
            about["n_duplicates"] = opened.geometry.count_repeats()
            step(0.4)
        if len(opened.geometry) and (picture or (not is_quick and opened.geometry.is_bare)):
            shown = as_map(opened)
            tree = tree or fl.build(shown.geometry, effort=0, progress=lambda done: step(0.4 + 0.5 * done))
            radius = _suitable(tree)
        if picture or not is_quick:
            about["radius_for_pictures"] = radius
    facts["build"] = _build_facts(opened)
    if as_json:
        typer.echo(json.dumps(facts, indent=2))
        return
    typer.echo(opened.name + (f": {opened.format.description}" if opened.format else ""))
    for line in facts_text(facts):
        typer.echo(line)
    if is_quick:
        needs = "" if picture or not opened.geometry.is_bare else ", and finds a radius for pictures"
        typer.echo(f"         --full counts duplicates{needs}")
    if picture and tree is not None:
        typer.echo(draw(shown, tree, radius or 0.0))


def facts_text(facts: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each fact about lines, other shapes, a tree or a forest."""
    for part in ("lines", "shapes", "tree", "build", "forest"):
        for key, value in facts.get(part, {}).items():
            if key == "radius_for_pictures" and value is None:
                continue  # they have their own radius
            name = key.removeprefix("n_").removesuffix("_bytes").replace("_", " ")
            yield f"{part:>7}  {name:<19} {_text(key, value)}"


def _build_facts(opened: Source) -> dict[str, Any]:
    """Return what a build of the default tree takes by the model, or what the tree's own numbers say."""
    from .dry_run import memory_facts

    if isinstance(opened.tree, Tree):
        return memory_facts(opened.tree.n_prims, opened.tree.n_refs, opened.tree.settings)
    n_prims = len(opened.geometry.build_data()[1])
    settings = best_settings(n_prims=n_prims)
    return memory_facts(n_prims, expected_refs(n_prims, settings), settings)


@contextmanager
def _steps(is_long: bool) -> Iterator[Callable[[float], object]]:
    """Show a bar of what takes long; yield what takes the fraction that is done."""
    from .files import show_progress

    with reporting(show_progress() and is_long, "info") as callback:
        yield (lambda done: None) if callback is None else callback


def _suitable(tree: Tree) -> float | None:
    """Return the radius of pictures, if the lines have none."""
    from ..rendering.plan import PictureOptions, plan_picture

    return plan_picture(tree, PictureOptions()).radius if tree.geometry.is_bare else None


def draw(opened: Source, tree: Tree, radius: float) -> str:
    """Draw lines as text that fits the terminal, by the default camera."""
    from ..rendering.shading.depth_tone import grey
    from .terminal import has_colours, picture_text

    columns = max(16, min(COLUMNS, shutil.get_terminal_size((COLUMNS, 24)).columns))
    rows = columns // 2
    size: dict[str, Any] = {"width": columns, "height": 2 * rows}
    image = grey(fl.render(tree, opened.camera(), look="depth", radius=radius, samples=4, **size))
    lit = np.flatnonzero(image.any(axis=1)) // 2
    return picture_text(image[2 * lit.min(initial=rows) : 2 * lit.max(initial=0) + 2], has_colours())


def validate(tree_file: TreeFile, as_json: Json = False) -> None:
    """Check a tree: axioms 1 to 5, the axiom of its kind, Theorem 4, and that f = g (Theorem 1).

    If a node breaks an axiom, the command names both and exits with code 1.

    [bold]Examples[/]

    [cyan]fastlines validate hair.flt[/]

    [cyan]fastlines validate hair.flt --json[/]
    """
    from .files import open_tree

    tree = open_tree(tree_file)
    tree.validate()
    f, g = tree.cost(by="f"), tree.cost(by="g")
    difference = abs(f - g) / max(abs(f), abs(g), 1e-300)
    if not difference <= 1e-9:
        raise FastlinesError(f"{tree_file}: f = {f!r} and g = {g!r} differ, against Theorem 1; build the tree again")
    kind = "KD" if tree.settings.boxes == "cut" else "BVH"
    if as_json:
        typer.echo(json.dumps({"valid": True, "kind": kind, "n_nodes": tree.n_nodes, "cost_f": f, "cost_g": g}))
        return
    typer.echo(
        f"{tree_file}: valid: axioms 1 to 5, the {kind} axiom and Theorem 4 hold at {counted(tree.n_nodes, 'nodes')}; "
        f"f = g = {f:.9g} (they differ by {difference:.0e})"
    )


def _text(key: str, value: Any) -> str:
    """Write a value of `AnyGeometry.summary` or of `Tree.stats`."""
    if key == "bounds" and value:
        return " to ".join(_text("", corner) for corner in value)
    if key == "attributes" and isinstance(value, dict):
        return ", ".join(f"{name} ({kind})" for name, kind in value.items()) or "none"
    if key.endswith("_bytes"):
        return bytes_text(value)
    if isinstance(value, list):
        return "(" + ", ".join(_text("", item) for item in value) + ")" if value else "none"
    if isinstance(value, dict):
        return ", ".join(limit_notes(value)) or "none"
    if isinstance(value, float):
        return f"{value:.6g}" if not 1e5 <= abs(value) < 1e9 else f"{value:.10g}"  # coordinates far from zero
    if isinstance(value, int):
        return f"{value:,}"
    return "none" if value is None else str(value)
