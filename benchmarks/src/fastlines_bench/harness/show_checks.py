"""The output of the ratios that are wanted."""

from __future__ import annotations

from rich.console import Console

from .findings import Check


def print_checks(console: Console, checks: list[Check]) -> None:
    """Print whether each figure is within its bounds."""
    if not checks:
        return
    console.print("What is wanted:")
    for check in checks:
        verdict = {True: "yes", False: "NO", None: "not measured"}[check.holds]
        figure = (
            "–" if check.figure is None else f"{check.figure:.2f}" if check.figure >= 0.1 else f"{check.figure:.1e}"
        )
        bound = f"at least {check.least:g}" if check.least else f"at most {check.most:g}"
        named = f"{check.scene}, {check.what}" if check.scene else check.what
        console.print(f"  {verdict}: {named}: {figure}, {bound}", highlight=False)
