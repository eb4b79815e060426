"""Arrays in a file whose rows are read when they are needed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray


class StoredArray:
    """An array in a file; a slice reads these rows.

    Parameters
    ----------
    read : callable
        Takes the place of a byte and a number of bytes, and returns the bytes.
    dtype : data type
    shape : tuple of int
    at : int
        The byte at which the array starts.

    Examples
    --------
    >>> data = np.arange(6).tobytes()
    >>> StoredArray(lambda at, n: data[at : at + n], np.int64, (3, 2))[1:]
    array([[2, 3],
           [4, 5]])
    """

    def __init__(
        self, read: Callable[[int, int], bytes], dtype: npt.DTypeLike, shape: tuple[int, ...], at: int = 0
    ) -> None:
        self._read, self._at = read, at
        self.dtype, self.shape, self.ndim = np.dtype(dtype), shape, len(shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: slice) -> AnyArray:
        first, last, _ = rows.indices(len(self))
        shape = (max(last - first, 0), *self.shape[1:])
        size = math.prod(self.shape[1:]) * self.dtype.itemsize
        data = self._read(self._at + first * size, shape[0] * size)
        return np.frombuffer(data, self.dtype).reshape(shape)
