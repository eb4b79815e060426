"""Lists of many rows in one array: the entries of row i are `offsets[i]` to `offsets[i + 1]`."""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray
from ..errors import InputError


class CompressedRows:
    """Lists of hits for each ray, or of primitives for each point."""

    offsets: IntArray
    prim: IntArray

    def __len__(self) -> int:
        return len(self.prim)

    @property
    def counts(self) -> IntArray:
        """How many entries each ray or point has, int64."""
        return np.diff(self.offsets)

    @property
    def _row_of_entries(self) -> IntArray:
        """The row of each entry."""
        return np.repeat(np.arange(len(self.offsets) - 1), self.counts)

    def _entries_of(self, name: str, row: int) -> slice:
        """Return the slice of the entries of a row, which errors call by its name."""
        n_rows, nouns = len(self.offsets) - 1, f"{name}{'es' if name.endswith('x') else 's'}"
        is_whole = isinstance(row, int | np.integer) and not isinstance(row, bool)
        if not (is_whole and 0 <= row < n_rows):
            raise InputError(f"{name}={row}; expected a whole number from 0 to below {n_rows:,}, the number of {nouns}")
        return slice(int(self.offsets[row]), int(self.offsets[row + 1]))
