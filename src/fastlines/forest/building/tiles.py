"""Tiles: each is gathered from the parts, built and written, in this process or another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...progress import ProgressCallback, staged
from ..manifest import TileFacts
from ..mapping.mapping import Mapping as TaskMapping
from ..tile_files import write_tile
from .journal import Journal
from .partition import TileRows, gathered
from .plan import Plan
from .stage_file import read_stage, write_stage


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

    def done(self) -> int:
        """Build the tile in this process; see `Work`."""
        return build_tile(self)


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
    journal: Journal, tasks: Sequence[TileTask], mapping: TaskMapping | None, progress: ProgressCallback | None
) -> list[TileFacts]:
    """Build the tiles that are missing, and return the facts of all."""
    missing = [task for task in tasks if not journal.built(task.number).exists()]
    n_done = len(tasks) - len(missing)
    if mapping is not None:
        for _ in mapping.run(missing):
            n_done += 1
            if progress is not None:
                progress(n_done / len(tasks))
    for task in missing if mapping is None else ():
        build_tile(task, staged(progress, n_done / len(tasks), (n_done + 1) / len(tasks)))
        n_done += 1
    return [TileFacts(**read_stage(journal.built(task.number))[1]) for task in tasks]
