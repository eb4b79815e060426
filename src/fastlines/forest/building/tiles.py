"""Tiles: each is gathered from the parts, built and written, in this process or another."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ...progress import ProgressCallback
from ..manifest import TileFacts
from ..tile_files import write_tile
from .journal import Journal
from .partition import TileRows, gathered
from .plan import Plan
from .stage_file import read_stage, write_stage

#: Calls a function with each of some tasks, as `map` and `Executor.map` do, and returns what it returns, in order.
Map: TypeAlias = Callable[[Callable[[Any], Any], Sequence[Any]], Iterable[Any]]


@dataclass(frozen=True)
class TileTask:
    """A tile to build: small, so that it can be sent to another process, which has the same folder.

    Attributes
    ----------
    folder : str
        That of the forest.
    number : int
        Of the tile.
    rows : TileRows
    method, settings
        As `build` takes them.
    """

    folder: str
    number: int
    rows: TileRows
    method: str | None
    settings: Mapping[str, Any] = field(default_factory=dict)


def build_tile(task: TileTask, progress: ProgressCallback | None = None) -> int:
    """Build a tile and write its tree file and its facts; return its number."""
    journal = Journal(Path(task.folder))
    plan = Plan.read(journal)
    rows, ids = gathered(journal, plan, task.rows)
    given = rows.columns.pop("places", None)
    places = None if given is None else given.astype(np.int64)
    more = {**task.settings, "progress": progress or False}
    facts = write_tile(task.folder, task.number, rows.lines(plan.facts), ids, places, plan.frame, task.method, **more)
    write_stage(journal.built(task.number), {}, facts.as_json())
    return task.number


def build_tiles(
    journal: Journal, tasks: Sequence[TileTask], call: Map | None, progress: ProgressCallback | None
) -> list[TileFacts]:
    """Build the tiles that are missing, and return the facts of all."""
    missing = [task for task in tasks if not journal.built(task.number).exists()]
    n_done = len(tasks) - len(missing)
    if call is not None:
        for _ in call(build_tile, missing):
            n_done += 1
            if progress is not None:
                progress(n_done / len(tasks))
    for task in missing if call is None else ():
        build_tile(task, _share(progress, n_done, len(tasks)))
        n_done += 1
    return [TileFacts(**read_stage(journal.built(task.number))[1]) for task in tasks]


def _share(progress: ProgressCallback | None, n_done: int, n_all: int) -> ProgressCallback | None:
    """Return a callback for one of several tasks."""
    return None if progress is None else lambda done: progress((n_done + done) / n_all)
