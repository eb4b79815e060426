"""The tiles of a forest: mapped when they are queried, and kept open within a bound on memory."""

from __future__ import annotations

import contextlib
import os
import threading
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import IntArray
from ..errors import FileFormatError, InputError
from ..query.memory_check import left_bytes
from ..structure import tree_file
from ..support import container
from ..support.computed_once import held
from ..support.texts import bytes_text
from ..tree import Tree
from .manifest import ADVICE, Manifest, TileFacts
from .verified_files import is_verified, set_verified

#: Without a bound, tiles stay open while they take at most this share of the free memory.
FREE_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Tile:
    """A tile of a forest that is open.

    Attributes
    ----------
    number : int
    tree : Tree
        Over the primitives of the tile, in the frame of the forest.
    ids : None or (n,) int64
        Their numbers in the whole, rising; None if they are 0, 1, 2, …
    places : None or (n,) int64
        Their positions among the primitives of their strands, -1 for none; None if there are no strands.
    """

    number: int
    tree: Tree
    ids: IntArray | None = None
    places: IntArray | None = None


class TileStore:
    """Opens the tiles of a forest, for any number of threads; those that were used last stay open.

    Parameters
    ----------
    folder : path
    manifest : Manifest
    memory : int, optional
        How many bytes the open tiles may take. The default is half of the memory that is free. A tile that is in use
        stays in memory until it is no longer used, also where others have taken its place.
    verify : bool, optional
        Whether to verify the checksums of a tile when this process first opens it; see `load`.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        manifest: Manifest,
        memory: int | None = None,
        verify: bool | None = None,
    ) -> None:
        self.folder, self.manifest, self.memory, self.verify = Path(folder), manifest, memory, verify
        sizes = [tile.n_bytes for tile in manifest.tiles]
        largest = max(sizes, default=0)
        if memory is not None and memory < largest:
            file = manifest.tiles[sizes.index(largest)].file
            raise InputError(
                f"memory={memory} is less than the tile {file} of {folder} takes; give {largest} bytes "
                f"({bytes_text(largest)}) or more, or build the forest again with a smaller max_segments"
            )
        self._limit = max(FREE_SHARE * left_bytes(), largest) if memory is None else memory
        #: Whether each tile is open, so that it can be queried at once, (n_tiles,) uint8.
        self.is_open = np.zeros(len(manifest.tiles), np.uint8)
        self._open: OrderedDict[int, Tile] = OrderedDict()
        self._opened: set[int] = set()  # those that were open before, too
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self.manifest.tiles)

    def open(self, number: int) -> Tile:
        """Return a tile; open it, and close those that were not used for the longest time.

        Raises
        ------
        FileFormatError
            If its file is missing, truncated, damaged, or of another build than the manifest.
        """
        found = self._known(number)
        if found is not None:
            return found
        with held(self, f"tile {number}"):
            found = self._known(number)
            if found is not None:
                return found
            self._make_room(self.manifest.tiles[number].n_bytes)
            verify = None if self.verify and number in self._opened else self.verify
            tile = read_tile(self.folder, number, self.manifest.tiles[number], verify)
            with self._lock:
                self._open[number] = tile
                self._opened.add(number)
                self.is_open[number] = 1
            return tile

    def _known(self, number: int) -> Tile | None:
        """Return a tile if it is open, as the one that was used last."""
        with self._lock:
            if number not in self._open:
                return None
            self._open.move_to_end(number)
            return self._open[number]

    def _make_room(self, n_bytes: int) -> None:
        """Close tiles until this many bytes are free."""
        with self._lock:
            taken = sum(self.manifest.tiles[number].n_bytes for number in self._open)
            while self._open and taken + n_bytes > self._limit:
                number, _ = self._open.popitem(last=False)
                self.is_open[number] = 0
                taken -= self.manifest.tiles[number].n_bytes


def read_tile(folder: Path, number: int, facts: TileFacts, verify: bool | None = None) -> Tile:
    """Map a tile. Its checksums and its tree are checked unless this process has checked this version of the file.

    With ``verify=True`` both are checked in any case.
    """
    path = folder / facts.file

    def refuse(why: str) -> FileFormatError:
        advice = ADVICE
        with contextlib.suppress(FileFormatError, OSError, IndexError):
            if Manifest.read(folder).tiles[number].digest != facts.digest:
                why, advice = "it has been built again since the forest was opened", "open the forest again"
        return FileFormatError(f"{path} is not the tile {number} of this forest: {why}; {advice}")

    try:
        trusted = verify is not True and is_verified(path, verify)
        arrays, metadata = container.read(path, False if trusted else verify, advice=ADVICE)
        if path.stat().st_size != facts.n_bytes or container.digest_of(arrays) != facts.digest:
            raise refuse("it is of another build than the manifest")
    except FileNotFoundError:
        raise refuse("it is missing") from None
    tree = tree_file.from_arrays(Tree, path, arrays, metadata, trusted=trusted, advice=ADVICE)
    more = tree_file.more_of(arrays)
    n = len(tree.geometry)
    ids, places = (None if name not in more else np.asarray(more[name]) for name in ("ids", "places"))
    if n != facts.n_prims or any(column is not None and column.shape != (n,) for column in (ids, places)):
        raise refuse(f"it does not hold {facts.n_prims} primitives with their numbers")
    set_verified(path, verify)
    return Tile(number, tree, ids, places)
