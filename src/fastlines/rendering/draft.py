"""A draft of a picture: one sample of one pixel in each square, which stands for all pixels of the square.

It is there after a sixteenth of the time of a whole sample, and says how long such a sample takes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import AnyArray, IntArray

#: The side of a square in pixels.
SIDE = 4
#: Of the rows of squares, one of so many is in the first group.
FIRST = 16


@dataclass(frozen=True)
class Grid:
    """The pixels in the middle of the squares of a picture."""

    width: int
    height: int

    @property
    def shape(self) -> tuple[int, int]:
        """The number of rows and of columns of squares."""
        return -(-self.height // SIDE), -(-self.width // SIDE)

    def groups(self, n_groups: int, max_squares: int) -> list[IntArray]:
        """Divide the rows of squares into a small group and about so many equal ones, each from the whole picture.

        A group has `max_squares` at most, but always a row.

        Examples
        --------
        >>> [rows.tolist() for rows in Grid(4, 32).groups(2, max_squares=100)]
        [[0], [1, 3, 5, 7], [2, 4, 6]]
        """
        n_rows, n_columns = self.shape
        least = -(-n_rows // max(1, max_squares // n_columns))
        rows, step, n_groups = np.arange(n_rows), max(FIRST, least), max(n_groups, least)
        rest = rows[rows % step > 0]
        return [rows[::step], *(rest[i::n_groups] for i in range(min(n_groups, len(rest))))]

    def pixels(self, rows: IntArray) -> IntArray:
        """Return the numbers of the pixels of some rows of squares.

        Examples
        --------
        >>> Grid(8, 7).pixels(np.array([0, 1])).tolist()
        [18, 22, 50, 54]
        """
        columns = _middles(np.arange(self.shape[1]), self.width)
        return (_middles(rows, self.height)[:, None] * self.width + columns).ravel()


@dataclass(frozen=True)
class Draft:
    """What one sample adds to the sums of each pixel of a grid, by the name of the sum: (rows, columns, …)."""

    grid: Grid
    sums: Mapping[str, AnyArray]

    @classmethod
    def of(
        cls,
        grid: Grid,
        shapes: Mapping[str, tuple[int, ...]],
        groups: Sequence[IntArray],
        found: Sequence[Mapping[str, AnyArray]],
    ) -> Draft:
        """Join what is found in each group of rows; a sum that it lacks is 0."""
        sums = {name: np.zeros((*grid.shape, *shape)) for name, shape in shapes.items()}
        for rows, values in zip(groups, found, strict=True):
            for name, more in values.items():
                sums[name][rows] = np.reshape(more, (len(rows), *sums[name].shape[1:]))
        return cls(grid, sums)

    def rows(self, name: str, rows: IntArray) -> AnyArray:
        """Return a sum in all pixels of some rows of the picture, (n, width, …)."""
        return np.repeat(self.sums[name], SIDE, axis=1)[rows // SIDE, : self.grid.width]


def _middles(squares: IntArray, length: int) -> IntArray:
    """Return the middle pixel of some squares along one side of a picture."""
    return np.minimum(squares * SIDE + SIDE // 2, length - 1)
