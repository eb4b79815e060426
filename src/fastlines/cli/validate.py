"""``fastlines validate``: check that a tree is what the thesis defines."""

from __future__ import annotations

import json

import typer

from ..errors import FastlinesError
from .app import app
from .options import Json, TreeFile


@app.command(short_help="Check that a tree is what the thesis defines.")
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
        f"{tree_file}: valid: axioms 1 to 5, the {kind} axiom and Theorem 4 hold at all {tree.n_nodes:,} nodes; "
        f"f = g = {f:.9g} (they differ by {difference:.0e})"
    )
