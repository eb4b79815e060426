"""Values of strands from a table, such as the rows of a text file: which columns hold numbers, and their arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...arrays import AnyArray
from ...geometry.lines import Lines
from ...geometry.strand_attributes import with_strand_values
from ..source import Source

#: What stands for a missing value in text, in lower case.
MISSING = frozenset(("", "na", "n/a", "nan", "none", "null"))
#: Truth values in text, in lower case.
TRUTH = {"true": True, "false": False}
#: The most memory that columns take: a multiple of the bytes of their file, plus a constant.
BUDGET_FACTOR, BUDGET_BYTES = 4, 1 << 20
#: How many dropped columns a warning names.
SHOWN = 12


def value_of(text: str) -> object:
    """Return the number or truth value of a text; None if it stands for a missing value; else the text.

    Examples
    --------
    >>> [value_of(text) for text in ("12", " 1.5 ", "True", "n/a", "oak")]
    [12, 1.5, True, None, 'oak']
    """
    word = text.strip().lower()
    if word in MISSING:
        return None
    if word in TRUTH:
        return TRUTH[word]
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return text


def column_of(words: Sequence[str]) -> Sequence[object]:
    """Return the values of a column of texts, up to the first that is neither a number nor a truth value.

    Examples
    --------
    >>> column_of(["1", "2"]), column_of(["1.5", ""]), column_of(["oak", "2"])
    ([1, 2], [1.5, None], ['oak'])
    """
    try:
        return list(map(int, words))
    except ValueError:
        values = []
        for word in words:
            values.append(value_of(word))
            if isinstance(values[-1], str):
                break
        return values


def array_of(values: Sequence[object]) -> AnyArray | None:
    """Return a column as an array: bool, int64, or float64 with NaN where a value is None; None if it holds others.

    Examples
    --------
    >>> array_of([1, 2]), array_of([True, False]), array_of([1, None]), array_of([1, "oak"])
    (array([1, 2]), array([ True, False]), array([ 1., nan]), None)
    """
    kinds = {type(value) for value in values}
    if kinds == {bool}:
        return np.array(values, np.bool_)
    if not kinds or kinds == {type(None)} or not kinds <= {bool, int, float, type(None)}:
        return None
    if kinds <= {bool, int}:
        try:
            return np.array(values, np.int64)
        except OverflowError:
            pass
    return np.array([_float(value) for value in values], np.float64)


def _float(value: Any) -> float:
    try:
        return math.nan if value is None else float(value)
    except OverflowError:  # an integer beyond the largest number of float64
        return math.inf if value > 0 else -math.inf


def numeric(
    source: Source, columns: Mapping[str, tuple[Sequence[int], Sequence[object]]], n_rows: int, what: str
) -> dict[str, AnyArray]:
    """Return the columns of numbers as arrays of n rows, and warn once of the others.

    Each column is given as some rows and their values. The fullest ones are kept, as many as go well with the size of
    the file: columns with few values could take far more memory than their file.
    """
    arrays: dict[str, AnyArray] = {}
    dropped, sparse = [], []
    budget = BUDGET_FACTOR * source.size + BUDGET_BYTES
    for name, (rows, values) in sorted(columns.items(), key=lambda column: -len(column[1][0])):
        found = array_of(values)
        if found is None:
            dropped.append(name)
        elif (budget := budget - 8 * n_rows) < 0:
            sparse.append(name)
        elif np.array_equal(rows, np.arange(n_rows)):
            arrays[name] = found
        else:
            arrays[name] = np.full(n_rows, np.nan)
            arrays[name][rows] = found
    if dropped:
        source.warn(f"{what} that do not hold numbers are not kept: {listed(sorted(dropped))}")
    if sparse:
        source.warn(f"{len(sparse)} {what} with few values are not kept: {listed(sorted(sparse))}")
    return {name: arrays[name] for name in columns if name in arrays}


def listed(names: Iterable[str]) -> str:
    """Name some things for a warning.

    Examples
    --------
    >>> listed(["name", "tags"])
    "'name', 'tags'"
    """
    names = list(names)
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(repr(name[:60]) for name in names[:SHOWN]) + more


def counted(kinds: Mapping[str, int]) -> str:
    """Count things of several kinds for a warning.

    Examples
    --------
    >>> counted({"Point": 2, "Polygon": 1})
    '2 Point, 1 Polygon'
    """
    return ", ".join(f"{n} {kind}" for kind, n in kinds.items())


def with_strand_attributes(
    lines: Lines, per_strand: Mapping[str, AnyArray], unit: str | None = None, radius: AnyArray | None = None
) -> Lines:
    """Return the lines with a unit, and with values and the radius of strands, which are rows of the arrays."""
    lines = replace(with_strand_values(lines, per_strand), unit=unit)
    return lines if radius is None else lines.with_radius(radius[lines.strands])


def radius_of(source: Source, per_strand: dict[str, AnyArray], name: str | None, what: str) -> AnyArray | None:
    """Take the radius of strands out of the column of this name."""
    if name is None:
        return None
    if name not in per_strand:
        known = listed(per_strand) or "none"
        raise source.error(f"has no {what} {name!r} of numbers for the radius; those of numbers are: {known}")
    return source.radius(f"values of {name!r}, taken as the radius,", per_strand.pop(name))
