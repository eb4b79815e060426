"""The rows of a `Geometry` for rays that see some of its parts: those of the others are boxes that no ray hits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..support.immutable import own
from .shapes import BOX, shape_rows

#: A row of the core that no ray hits: a box whose low corner lies beyond its high one.
HIDDEN = shape_rows(BOX, np.array([[3e38] * 3 + [-3e38] * 3], np.float32))[0]

#: The most selections of parts whose rows are kept.
MOST_SEEN = 4


class SeenRows:
    """The rows of the latest selections of parts.

    Parameters
    ----------
    rows : (n, 10) float32
        Those of all parts.
    counts : sequence of int
        How many each part has.
    """

    def __init__(self, rows: FloatArray, counts: Sequence[int]) -> None:
        self._rows, self._ends = rows, np.cumsum(counts)
        self._kept: dict[tuple[int, ...], FloatArray] = {}

    def of(self, parts: tuple[int, ...]) -> FloatArray:
        """Return the rows for rays that see these parts."""
        if parts not in self._kept:
            rows = self._rows.copy()
            first = np.concatenate([[0], self._ends])
            for i in set(range(len(self._ends))).difference(parts):
                rows[first[i] : first[i + 1]] = HIDDEN
            while len(self._kept) >= MOST_SEEN:
                del self._kept[next(iter(self._kept))]
            self._kept[parts] = np.asarray(own(rows))
        return self._kept[parts]
