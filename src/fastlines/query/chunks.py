"""Queries that Python answers with arrays of pairs, of some rays or points at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..progress import ProgressCallback

#: The most rays or points that the core searches at a time, and about how many pairs are tested: Ctrl-C waits for
#: these.
CHUNK_ROWS, CHUNK_PAIRS = 1 << 14, 1 << 20


@dataclass
class Chunks:
    """Rays or points to search at a time: about `CHUNK_PAIRS` pairs, by the number that the last ones had."""

    n: int
    #: How many are searched first, and next.
    size: int
    progress: ProgressCallback | None
    n_pairs: int = 0

    def __iter__(self) -> Iterator[slice]:
        begin = 0
        while begin < self.n:
            end = min(begin + self.size, self.n)
            yield slice(begin, end)
            if self.progress is not None:
                self.progress(end / self.n)
            begin = end
            fitting = self.size * CHUNK_PAIRS // max(1, self.n_pairs)
            self.size = min(max(1, fitting), 4 * self.size, CHUNK_ROWS)
