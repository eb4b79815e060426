"""Values of strands as attributes of lines: columns of numbers and of texts, and the number of a strand's feature."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import AnyArray
from ..support.immutable import own
from .lines import Lines

#: The attribute with the number of the feature, row, track or entity that a strand is of, from 0.
FEATURE = "feature"
#: What stands for a missing text in an array.
NO_TEXT = ""


def with_strand_values(lines: Lines, values: Mapping[str, AnyArray], of: str = "strand") -> Lines:
    """Return lines with more attributes, which have a row for each strand and are repeated for its segments.

    Parameters
    ----------
    values : mapping of str to array
        The strands of the lines are rows of the arrays.
    of : str
        Where a name is taken, `` of `` and this are appended to it.

    Examples
    --------
    >>> lines = Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[5, 5, 5], [6, 6, 6]]])
    >>> with_strand_values(lines, {"age": np.array([30, 40])}).attributes["age"]
    array([30, 30, 40])
    """
    attributes = dict(lines.attributes)
    for name, rows in values.items():
        while name in attributes:
            name += f" of {of}"
        attributes[name] = own(rows[lines.strands])
    return replace(lines, attributes=attributes)


def array_of(values: Sequence[object]) -> AnyArray | None:
    """Return a column as an array; None if it holds nothing, or values that are neither numbers nor texts.

    Numbers are bool, int64, or float64 with NaN where a value is None. Texts are objects, `NO_TEXT` where a value is
    None; numbers among texts become texts.

    Examples
    --------
    >>> array_of([1, 2]), array_of([True, False]), array_of([1, None]), array_of([1, "oak", None])
    (array([1, 2]), array([ True, False]), array([ 1., nan]), array(['1', 'oak', ''], dtype=object))
    """
    kinds = {type(value) for value in values}
    if kinds == {bool}:
        return np.array(values, np.bool_)
    if not kinds - {type(None)} or not kinds <= {bool, int, float, str, type(None)}:
        return None
    if str in kinds:
        return objects(NO_TEXT if value is None else value if isinstance(value, str) else json.dumps(value)
                       for value in values)  # fmt: skip
    if kinds <= {bool, int}:
        try:
            return np.array(values, np.int64)
        except OverflowError:
            pass
    return np.array([_float(value) for value in values], np.float64)


def objects(values: Iterable[object]) -> AnyArray:
    """Return an array of Python objects."""
    listed = list(values)
    array = np.empty(len(listed), object)
    array[:] = listed
    return array


def _float(value: Any) -> float:
    try:
        return math.nan if value is None else float(value)
    except OverflowError:  # an integer beyond the largest number of float64
        return math.inf if value > 0 else -math.inf
