"""How long it takes to open a saved tree and to run the first query, with and without a saved layout.

A file is opened for the first time, with all checks, or again: as a file that this process has checked before, without
them. The file is in the memory of the system.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.clock import best_of
from ..harness.internals import tree_file

ROUNDS = 5

#: The radius of thick lines, in the unit of the scene.
RADIUS = 0.001


def steps_of(folder: Path, lines: fl.Lines) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Save a tree without and with its layout, and return what is timed, by its name."""
    tree = fl.build(lines)
    for name, layout in (("", False), (", with a layout", True)):
        path = folder / f"{layout}.flt"
        tree.save(path, layout=layout)
        opened = {
            "load": partial(fl.load, path, verify=True),
            "load without checksums": partial(fl.load, path, verify=False),
            "open again": partial(tree_file.read, fl.Tree, path, False, trusted=True),
        }
        for step, do in opened.items():
            yield step + name, do
            yield f"{step}, first query{name}", partial(_ask, do)


def _ask(load: Callable[[], fl.Tree]) -> None:
    load().first_hit([0, 0, -9], [0, 0, 1], RADIUS)


def print_opening(segments: int) -> None:
    """Print a table for lines without and with a radius."""
    lines = fl.scenes.make("spaghetti", segments).lines
    times: dict[str, list[str]] = {}
    for each in (lines, lines.with_radius(np.full((len(lines), 2), RADIUS, np.float32))):
        with TemporaryDirectory() as folder:
            for name, do in steps_of(Path(folder), each):
                seconds, _ = best_of(ROUNDS, 2, do)
                times.setdefault(name, []).append(f"{1000 * seconds:.1f}")
    print(f"| {segments:,} segments | ms | with a radius |\n|---|--:|--:|")
    for name, cells in times.items():
        print(f"| {name} | {' | '.join(cells)} |")
