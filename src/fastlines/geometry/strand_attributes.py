"""Values of strands as attributes of lines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..arrays import AnyArray
from ..support.immutable import own
from .lines import Lines


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
    >>> import numpy as np
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
