"""Several lines as one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import AnyArray, IntArray
from ..support.immutable import own
from .lines import Lines
from .offsets import OFFSET


def join_lines(parts: Sequence[Lines], name: str, numbers: Sequence[int], warn: Callable[[str], None]) -> Lines:
    """Return the segments of several lines, one after the other; strands count on from one part to the next.

    Parameters
    ----------
    parts : sequence of Lines
        At least one; all have the same offset.
    name : str
        The attribute that has the number of the part of each segment.
    numbers : sequence of int
        The number of each part.
    warn : callable
        Takes what is left out or assumed, in words.

    Examples
    --------
    >>> parts = [Lines.from_strands([[[0, 0, z], [1, 0, z], [2, 0, z]]]) for z in (0, 1)]
    >>> lines = join_lines(parts, "block", [0, 2], print)
    >>> print(lines.strands, lines.attributes["block"])
    [0 0 1 1] [0 0 2 2]
    """
    sizes = [len(part) for part in parts]
    radius = None
    if any(part.radius is not None for part in parts):
        if n_bare := sum(part.radius is None for part in parts):
            warn(f"{n_bare} of {len(parts)} parts have no radius, and get the radius 0")
        radius = np.concatenate([part.end_radii for part in parts])
    attributes = _shared([_plain(part) for part in parts], warn)
    ends = _shared([part.end_attributes for part in parts], warn)
    first = parts[0]
    for fact in ("unit", "up"):
        if len({getattr(part, fact) for part in parts}) > 1:
            warn(f"parts differ in {fact}; it is {getattr(first, fact)!r}, that of the first")
    return Lines(
        own(np.concatenate([part.segments for part in parts])),
        own(_strands(parts)),
        None if radius is None else own(radius),
        {name: np.repeat(np.array(numbers, np.int64), sizes), **{of: v for of, v in attributes.items() if of != name}},
        up=first.up,
        unit=first.unit,
        end_attributes=ends,
        metadata={OFFSET: first.metadata[OFFSET]} if OFFSET in first.metadata else {},
    )


def _strands(parts: Sequence[Lines]) -> IntArray:
    """Return the strands of all parts, each part's after those of the parts before; -1 stays."""
    first = np.cumsum([0] + [int(part.strands.max(initial=-1)) + 1 for part in parts[:-1]])
    shifted = [np.where(part.strands < 0, -1, part.strands + at) for part, at in zip(parts, first, strict=True)]
    return np.asarray(np.concatenate(shifted))


def _plain(part: Lines) -> Mapping[str, AnyArray]:
    """Return the attributes of whole segments."""
    return {name: values for name, values in part.attributes.items() if name not in part.end_attributes}


def _shared(columns: Sequence[Mapping[str, AnyArray]], warn: Callable[[str], None]) -> dict[str, Any]:
    """Join the columns that all parts have in the same shape."""
    found, left_out = {}, []
    for name in dict.fromkeys(name for part in columns for name in part):
        given = [part[name] for part in columns if name in part]
        if len(given) < len(columns) or len({values.shape[1:] for values in given}) > 1:
            left_out.append(repr(name))
        else:
            found[name] = np.concatenate(given)
    if left_out:
        warn(f"attributes that not all parts have alike are left out: {', '.join(left_out)}")
    return found
