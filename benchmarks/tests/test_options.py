"""The options of the commands are those that the manual names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from fastlines_bench.cli import app

MANUAL = (Path(__file__).parents[2] / "docs" / "benchmarks.md").read_text(encoding="utf-8")


def commands(group: Any, inside: str = "") -> Iterator[tuple[str, set[str]]]:
    """Yield each command by its name, with its options."""
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, f"{name} ")
        else:
            yield inside + name, {option for parameter in command.params for option in parameter.opts}


def test_the_manual_says_which_commands_have_which_options() -> None:
    known = dict(commands(typer.main.get_command(app)))
    said = re.search(r"All commands have `--help`.*?Earlier results", MANUAL, re.DOTALL)
    assert said is not None
    names = set(re.findall(r"`([a-z]+)`", said[0].partition("`--plot FILE.png` draws")[2]))
    assert names == {name for name, options in known.items() if "--plot" in options}
    studies = {name for name in known if name.startswith("study ")}
    slow = {name for name, options in known.items() if "--quick" not in options}
    assert slow == studies | {"soak", "faults", "mutation"}
    without = {name for name, options in known.items() if "--json" not in options}
    assert without - studies == {"thesis", "answers"}
    assert studies - without == {"study beams", "study bounds", "study lookahead"}
