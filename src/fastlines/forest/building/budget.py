"""The memory of a build: how many segments a chunk, a part and a tile have within it."""

from __future__ import annotations

from dataclasses import dataclass

from ...arrays import byte_count, count
from ...errors import InputError
from ...settings.build_memory import build_bytes, expected_refs, layout_bytes
from ...settings.settings import Settings

#: The most segments of a tile, and of a chunk or a part, however much memory there is.
TILE, CHUNK = 2_000_000, 1_000_000

#: The fewest segments of a tile, a chunk or a part for which memory must suffice.
LEAST = 16_384


@dataclass(frozen=True)
class BuildTuning:
    """The bytes that a build takes, with room to spare; `fastlines-bench scale --part memory` shows that they hold.

    A tile takes what `build_bytes` and `layout_bytes` say, and beside these so many bytes for each of its segments, and
    so many times the bytes of its row of columns. So does a chunk while it is read, or a part while it is sorted. Rows
    of chunks are taken to have `row` bytes.
    """

    process: int = 100_000_000
    tile: int = 16
    tile_row: int = 2
    chunk: int = 30
    chunk_row: int = 3
    row: int = 80


TUNING = BuildTuning()


@dataclass(frozen=True)
class Budget:
    """What a build may take.

    Attributes
    ----------
    memory : int, optional
        The bytes that the process may take, with everything that it holds.
    max_segments : int, optional
        The most segments of a tile.
    settings : Settings
        Those of the builds of tiles.
    """

    memory: int | None
    max_segments: int | None
    settings: Settings

    def __post_init__(self) -> None:
        if self.max_segments is not None:
            count("max_segments", self.max_segments, 1)
        if self.memory is not None:
            byte_count("memory", self.memory)
            self.most_of(0)

    @property
    def n_rows(self) -> int:
        """The most segments of a chunk or a part."""
        return min(CHUNK, max(LEAST, self._left // self._a_row))

    @property
    def at_once(self) -> int:
        """How many parts are sorted at a time."""
        return max(1, min(2, self._left // (self.n_rows * self._a_row)))

    def most_of(self, row_bytes: int) -> int:
        """Return the most segments of a tile whose columns take so many bytes a segment.

        Raises
        ------
        InputError
            If the memory is not enough for that.
        """
        layout = layout_bytes(expected_refs(TILE, self.settings))[1]
        a_tree = (build_bytes(TILE, self.settings) + layout) // TILE
        a_segment = a_tree + TUNING.tile + TUNING.tile_row * row_bytes
        wanted, fits = self.max_segments or LEAST, self._left // a_segment
        if fits < wanted:
            least = TUNING.process + a_segment * wanted
            of = f" of max_segments={wanted}" if self.max_segments else ""
            fewer = f", or max_segments={fits}" if self.max_segments and fits > 0 else ""
            raise InputError(
                f"memory={self.memory} is less than the build of a tile{of} takes; give {least} bytes or more{fewer}"
            )
        return self.max_segments or min(TILE, fits)

    @property
    def _left(self) -> int:
        """The bytes that are left beside the process."""
        return 1 << 62 if self.memory is None else max(0, self.memory - TUNING.process)

    @property
    def _a_row(self) -> int:
        return TUNING.chunk + TUNING.chunk_row * TUNING.row
