"""Builds of forests: from sources that need not fit into memory, in stages that a second call goes on with."""

from __future__ import annotations

import os
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import INVALID, choice
from ...builder import build
from ...errors import InputError
from ...geometry.offsets import check_offset
from ...progress import ProgressOption, reporting, staged
from ..forest import Forest
from ..mapping.where import mapping_of
from ..writing import write_manifest
from .budget import Budget
from .index import index_tiles
from .journal import Journal
from .partition import partition, tiles_of
from .plan import make_plan
from .repair import is_whole
from .source import Reading, source_of
from .spill import Spill
from .tiles import TileTask, build_tiles

#: The fraction of the work after which each stage ends.
SPILLED, PARTITIONED, BUILT = 0.2, 0.35, 0.97


def build_forest(
    source: Any,
    folder: str | os.PathLike[str],
    *,
    max_segments: int | None = None,
    memory: int | None = None,
    method: str | None = None,
    offset: Any = None,
    invalid: str = "error",
    map: Any = None,
    progress: ProgressOption = False,
    **settings: Any,
) -> Forest:
    """Build a forest of lines that need not fit into memory.

    The lines are read once and divided into tiles: the scene is halved at medians of the centroids of its segments.
    Then each tile becomes a tree, whose file is in the folder. Numbers, strands, rows and attributes are those of all
    chunks joined: strands count on from chunk to chunk.

    If the call ends early, whatever the reason, the same call goes on where it ended, and the forest is the same, byte
    for byte. A whole forest of files or of a dask array is verified, repaired and opened. Whether one is of the chunks
    of an iterator cannot be told, so the call is refused: open it by `Forest`.

    Parameters
    ----------
    source : path, several paths, iterator, dask array, or what `lines` takes
        A file that `read_chunks` reads, a folder of Parquet files, or a list of these, one after the other. An
        iterator of chunks: Lines, arrays (n, 2, 3), or lists of polylines; to go on with an interrupted build, it is
        given again from its beginning. A dask array (n, 2, 3).
    folder : path
        It is made; or it is empty, or has an interrupted build of the same source and settings.
    max_segments : int, optional
        The most segments of a tile; by default 2,000,000, or fewer if `memory` is less than these take.
    memory : int, optional
        The most bytes that the process may take. Chunks of an iterator, and blocks of a dask array, come on top, and so
        do the row groups of Parquet and 100 MB for its library. With `map`, it counts for each process that builds
        tiles.
    method, **settings
        Of the trees of the tiles, as `build` takes them, but for `frame`: it is the box of all lines.
    offset : "auto" or three numbers, optional
        Subtracted from x, y and z in float64, as in `read`; one for all chunks. "auto" is that of the first file or
        chunk.
    invalid : {"error", "skip"}
        Refuse segments that hold NaN or Inf, or leave them out, as in `read`.
    map : callable or Client of dask.distributed, optional
        Builds several tiles at a time, as `Forest.on` takes it: the `map` of an executor of `concurrent.futures`, for
        example, or the workers of Dask. Tasks are small, and their processes see the same folder.
    progress : bool or callable
        Show a bar, or call back with the fraction that is done.

    Returns
    -------
    Forest

    Raises
    ------
    InputError
        If the source, the memory or a setting cannot be used, or the folder holds something else.
    OSError
        If a file cannot be read or written. After a disk was full, the same call goes on.

    Warns
    -----
    FileWarning
        Of attributes, radii and facts that not all chunks have alike.

    Examples
    --------
    >>> import os, tempfile
    >>> import fastlines as fl
    >>> chunks = ([[[x, y, 0], [x + 1, y, 0]] for x in range(10)] for y in range(10))
    >>> forest = fl.build_forest(chunks, os.path.join(tempfile.mkdtemp(), "grid"), max_segments=30)
    >>> forest.n_prims, forest.n_tiles
    (100, 4)
    >>> print(forest.first_hit([5.5, 2, 9], [0, 0, -1], radius=0.1).prim)
    25
    """
    choice("invalid", invalid, INVALID)
    if "frame" in settings:
        raise InputError("the frame of a forest is the box of all its lines; leave frame= out")
    wanted = check_offset(offset)
    mapping = None if map is None else mapping_of(map, None, "map")
    # A tree of one segment shows what is wrong with the settings.
    tree = build(np.zeros((1, 2, 3), np.float32), method, **settings)
    budget = Budget(memory, max_segments, tree.settings)
    given = source_of(source)
    journal = Journal(Path(folder))
    what = {
        "source": given.facts,
        "max_segments": max_segments,
        "memory": memory if max_segments is None else None,
        "method": method,
        "settings": {name: repr(value) for name, value in sorted(settings.items())},
        "offset": wanted,
        "invalid": invalid,
        "fastlines": version("fastlines"),
    }
    journal.check(what)
    with journal.explaining(), journal.locked(), reporting(progress, "build the forest") as callback:
        journal.begin(what)
        is_built = journal.is_finished and is_whole(journal, callback)
        if not is_built:
            Spill(journal, Reading(budget.n_rows, offset, invalid)).run(given, staged(callback, 0, SPILLED))
            plan = make_plan(journal, budget)
            partition(journal, plan, budget.at_once, staged(callback, SPILLED, PARTITIONED))
            tiles = tiles_of(journal, plan.most)
            tasks = [TileTask(os.path.abspath(folder), i, rows, method, settings) for i, rows in enumerate(tiles)]
            facts = build_tiles(journal, tasks, mapping, staged(callback, PARTITIONED, BUILT))
            index = index_tiles(journal, plan, tiles, settings.get("own_radius", True))
            write_manifest(folder, plan.frame, facts, index, tree.method, n_strands=plan.n_strands, facts=plan.facts)
    journal.clear()
    if is_built and given.is_stream:
        raise InputError(
            f"{folder} holds a whole forest, and whether it is of these chunks cannot be told; fl.Forest opens it; "
            "delete the folder to build another, or name a new one"
        )
    return Forest(folder, memory=memory)
