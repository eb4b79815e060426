"""Values of strands from a table, such as the rows of a text file: columns of numbers and of texts, as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray
from ...geometry.lines import Lines
from ...geometry.strand_attributes import FEATURE, NO_TEXT, array_of, objects, with_strand_values
from ...support.texts import listed
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
    """Return the values of a column of texts: numbers and truth values, or the texts themselves if any is neither.

    Examples
    --------
    >>> column_of(["1", "2"]), column_of(["1.5", ""]), column_of(["oak", "2"])
    ([1, 2], [1.5, None], ['oak', '2'])
    """
    try:
        return list(map(int, words))
    except ValueError:
        values = []
        for word in words:
            values.append(value_of(word))
            if isinstance(values[-1], str):
                return words
        return values


def kept_columns(
    source: Source, columns: Mapping[str, tuple[Sequence[int], Sequence[object]]], n_rows: int, what: str
) -> dict[str, AnyArray]:
    """Return the columns of numbers and of texts as arrays of n rows, and warn once of the others.

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
            missing = objects([NO_TEXT]) if found.dtype == object else np.array([np.nan])
            arrays[name] = np.repeat(missing, n_rows)
            arrays[name][rows] = found
    if dropped:
        source.warn(f"{what} that hold neither numbers nor texts are not kept: {quoted(sorted(dropped))}")
    if sparse:
        source.warn(f"{len(sparse)} {what} with few values are not kept: {quoted(sorted(sparse))}")
    return {name: arrays[name] for name in columns if name in arrays}


def quoted(names: Iterable[str]) -> str:
    """Name some things for a warning.

    Examples
    --------
    >>> quoted(["name", "tags"])
    "'name', 'tags'"
    """
    return listed((repr(name[:60]) for name in names), most=SHOWN)


def with_features(
    lines: Lines,
    feature: npt.ArrayLike,
    per_strand: Mapping[str, AnyArray],
    unit: str | None = None,
    radius: AnyArray | None = None,
) -> Lines:
    """Return the lines with a unit, the number of each strand's feature, and values and the radius of strands."""
    features = {FEATURE: np.asarray(feature, np.int64)}
    lines = replace(with_strand_values(with_strand_values(lines, features), per_strand), unit=unit)
    return lines if radius is None else lines.with_radius(radius[lines.strands])


def radius_of(source: Source, per_strand: dict[str, AnyArray], name: str | None, what: str) -> AnyArray | None:
    """Take the radius of strands out of the column of this name."""
    if name is None:
        return None
    if name not in per_strand or per_strand[name].dtype == object:
        known = quoted(name for name, values in per_strand.items() if values.dtype != object) or "none"
        raise source.error(f"has no {what} {name!r} of numbers for the radius; those of numbers are: {known}")
    return source.radius(f"values of {name!r}, taken as the radius,", per_strand.pop(name))
