"""Repair: what is left of a forest whose files are damaged is kept, and the rest is built again."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ...errors import FileFormatError
from ...progress import ProgressCallback
from ..index import Index
from ..manifest import Manifest
from ..tile_store import read_tile
from .journal import Journal
from .stage_file import write_stage


def is_whole(journal: Journal, progress: ProgressCallback | None) -> bool:
    """Verify a forest that is built; if a file is damaged, it is half built afterwards, without that file."""
    try:
        manifest = Manifest.read(journal.folder)
    except FileFormatError:
        journal.reopen()
        return False
    intact = []
    for number, tile in enumerate(manifest.tiles):
        if _can_be_read(partial(read_tile, journal.folder, number, tile, True)):
            intact.append(number)
        if progress is not None:
            progress((number + 1) / len(manifest.tiles))
    index_is_whole = _can_be_read(lambda: Index.read(journal.folder, manifest.n_prims, manifest.index, True))
    if len(intact) == len(manifest.tiles) and index_is_whole:
        return True
    for number in intact:
        write_stage(journal.built(number), {}, manifest.tiles[number].as_json())
    for number in {*range(len(manifest.tiles))} - {*intact}:
        (journal.folder / manifest.tiles[number].file).unlink(missing_ok=True)
    journal.reopen()
    return False


def _can_be_read(read: Callable[[], object]) -> bool:
    try:
        read()
    except FileFormatError:
        return False
    return True
