"""The memory of a build: how many segments a chunk, a part and a tile have within it."""

from __future__ import annotations

from dataclasses import dataclass

from ...arrays import count
from ...errors import InputError

#: Without a bound on memory: the most segments of a tile, and of a chunk or a part.
TILE, CHUNK = 2_000_000, 1_000_000

#: The fewest segments of a chunk or a part.
LEAST_CHUNK = 16_384


@dataclass(frozen=True)
class BuildTuning:
    """Bytes that a build takes, measured by `benchmarks` on streamlines with 0 and with 40 bytes of attributes.

    Attributes
    ----------
    process
        Of Python with the package.
    tile, tile_row
        Of a tile, for each of its segments: so many, and so many times the bytes of its columns.
    chunk, chunk_row
        Of a chunk while it is read, or a part while it is sorted.
    """

    process: int = 160_000_000
    tile: int = 160
    tile_row: int = 4
    chunk: int = 100
    chunk_row: int = 4


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
    """

    memory: int | None
    max_segments: int | None

    def __post_init__(self) -> None:
        if self.max_segments is not None:
            count("max_segments", self.max_segments, 1)
        if self.memory is not None:
            count("memory", self.memory, 0)
            self.most_of(0)

    @property
    def n_rows(self) -> int:
        """The most segments of a chunk or a part; a quarter of them where memory is scarce."""
        if self.memory is None:
            return CHUNK
        left = self.memory - TUNING.process
        return max(LEAST_CHUNK, min(CHUNK, left // (TUNING.chunk + TUNING.chunk_row * 40)))

    @property
    def at_once(self) -> int:
        """How many parts are sorted at a time."""
        if self.memory is None:
            return 2
        part = self.n_rows * (TUNING.chunk + TUNING.chunk_row * 40)
        return max(1, min(2, (self.memory - TUNING.process) // part))

    def most_of(self, row_bytes: int) -> int:
        """Return the most segments of a tile whose columns take so many bytes a segment.

        Raises
        ------
        InputError
            If the memory is not enough for that.
        """
        a_segment = TUNING.tile + TUNING.tile_row * row_bytes
        if self.memory is None:
            return self.max_segments or TILE
        most = (self.memory - TUNING.process) // a_segment
        wanted = LEAST_CHUNK if self.max_segments is None else self.max_segments
        if most < min(wanted, LEAST_CHUNK) or most < (self.max_segments or 0):
            least = TUNING.process + a_segment * max(wanted, LEAST_CHUNK)
            of = "" if self.max_segments is None else f" of max_segments={self.max_segments}"
            fewer = "" if self.max_segments is None or most < LEAST_CHUNK else f", or max_segments={most}"
            raise InputError(
                f"memory={self.memory} is less than the build of a tile{of} takes; give {least} bytes or more{fewer}"
            )
        return self.max_segments or most
