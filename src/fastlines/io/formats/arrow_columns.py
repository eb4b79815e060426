"""The columns of a table as arrays: numbers, and strands, which may have texts for numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa

from ...arrays import AnyArray, IntArray
from ..source import Source
from .arrow_table import is_text, numbers_of


def values_of(source: Source, name: str, column: Any, n_empty: int | None = None) -> AnyArray:
    """Return a column of numbers as an array, (n,) or (n, k).

    Parameters
    ----------
    n_empty : int, optional
        How many empty rows the whole table has there, where this is a part of it, and `warn_of_empty` has warned.
    """
    kind, shape = numbers_of(column.type) or (column.type, [])
    if pa.types.is_dictionary(column.type):
        column = column.cast(kind)
    n = len(column)
    whole = column.combine_chunks() if column.num_chunks != 1 else column.chunk(0)
    for _ in shape:
        if whole.null_count:
            raise source.error(f"the column {name!r} has {whole.null_count} empty rows; fill them, or leave them out")
        whole = whole.flatten()
    if n_empty is None and not pa.types.is_floating(kind):
        n_empty = whole.null_count
        warn_of_empty(source, name, n_empty)
    if n_empty and not pa.types.is_floating(kind):
        whole = whole.cast(pa.int8()) if pa.types.is_boolean(kind) else whole
        whole = whole.cast(pa.float64(), safe=False)
    flat = np.asarray(whole.to_numpy(zero_copy_only=False))
    return flat.reshape(n, *shape) if shape else flat


def warn_of_empty(source: Source, name: str, n_empty: int) -> None:
    """Warn of empty rows in a column of whole numbers."""
    if n_empty:
        source.warn(f"the column {name!r} has {n_empty} empty rows, which are NaN; so it is of type float64")


def strands_of(source: Source, column: Any) -> IntArray:
    """Return a number for the strand of each row."""
    is_coded = pa.types.is_dictionary(column.type)
    if is_coded and not is_text(column.type.value_type):
        column, is_coded = column.cast(column.type.value_type), False
    elif is_text(column.type):
        column, is_coded = column.dictionary_encode(), True
    column = column.unify_dictionaries() if is_coded else column
    texts = column.chunk(0).dictionary if is_coded and column.num_chunks else None
    n_empty = column.null_count + (texts.null_count if texts is not None else 0)
    check_filled(source, n_empty)
    if is_coded:
        if texts is None:
            return np.empty(0, np.int64)
        # Number the texts in the order in which they come first; a dictionary may hold a text twice.
        same = texts.dictionary_encode().indices.to_numpy(zero_copy_only=False)
        codes = same[np.concatenate([chunk.indices.to_numpy(zero_copy_only=False) for chunk in column.chunks])]
        _, first, number = np.unique(codes, return_index=True, return_inverse=True)
        return np.asarray(np.argsort(np.argsort(first))[number], np.int64)
    numbers = np.asarray(column.to_numpy())
    if len(numbers):
        check_range(source, numbers.min(), numbers.max())
    return numbers.astype(np.int64)


def check_filled(source: Source, n_empty: int) -> None:
    """Refuse empty rows in the column of strands."""
    if n_empty:
        raise source.error(f"the column 'strand' has {n_empty} empty rows; fill them, or leave them out")


def check_range(source: Source, low: int, high: int) -> None:
    """Refuse numbers of strands that are not from -1 to the largest of int64."""
    if high > np.iinfo(np.int64).max or low < -1:
        raise source.error(f"the column 'strand' has numbers from {low} to {high}; expected 0 or more")


class StrandNumbers:
    """The numbers of strands of a table that comes in parts; texts are numbered in the order in which they come first.

    Attributes
    ----------
    rises : bool
        Whether each number of a strand was at least the one before; -1 is none.
    """

    def __init__(self, source: Source) -> None:
        self._source, self._numbers = source, dict[str, int]()
        self._n_empty, self._low, self._high = 0, 0, -1
        self._last = -1
        self.rises = True

    def survey(self, column: Any) -> None:
        """Look at the next part of the column."""
        self._n_empty += column.null_count
        if self._n_empty or not len(column):
            return
        numbers = self.of(column)
        self._low, self._high = min(self._low, int(numbers.min())), max(self._high, int(numbers.max()))
        used = numbers[numbers >= 0]
        if len(used) and self.rises:
            self.rises = bool(used[0] >= self._last and (used[1:] >= used[:-1]).all())
            self._last = int(used[-1])

    def check(self) -> None:
        """Refuse what `strands_of` refuses."""
        check_filled(self._source, self._n_empty)
        check_range(self._source, self._low, self._high)

    def of(self, column: Any) -> AnyArray:
        """Return the number of each row of a part of the column."""
        is_coded = pa.types.is_dictionary(column.type)
        if is_coded and not is_text(column.type.value_type):
            column, is_coded = column.cast(column.type.value_type), False
        elif is_text(column.type):
            column, is_coded = column.dictionary_encode(), True
        if not is_coded:
            return np.asarray(column.to_numpy())
        parts = [np.empty(0, np.int64)]
        for chunk in column.chunks:
            codes = chunk.indices.to_numpy(zero_copy_only=False)
            used, first, which = np.unique(codes, return_index=True, return_inverse=True)
            texts = chunk.dictionary.take(pa.array(used)).to_pylist()
            for i in np.argsort(first).tolist():
                self._numbers.setdefault(texts[i], len(self._numbers))
            parts.append(np.array([self._numbers[text] for text in texts], np.int64)[which.reshape(-1)])
        return np.concatenate(parts)
