"""Chunks of lines, joined as their strands and rows count on."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl


def joined(chunks: Sequence[fl.Lines]) -> fl.Lines:
    """Return the lines of all chunks."""
    strands, skipped = [], []
    n_strands = n_rows = 0
    for chunk in chunks:
        strands.append(np.where(chunk.strands < 0, -1, chunk.strands + n_strands))
        skipped.append(chunk.skipped + n_rows)
        n_strands += int(chunk.strands.max(initial=-1)) + 1
        n_rows += len(chunk) + len(chunk.skipped)
    first = chunks[0]
    return fl.Lines(
        np.concatenate([chunk.segments for chunk in chunks]),
        np.concatenate(strands),
        None if first.radius is None else np.concatenate([chunk.radius for chunk in chunks]),
        {name: np.concatenate([chunk.attributes[name] for chunk in chunks]) for name in first.attributes},
        np.concatenate(skipped),
        first.up,
        {name: np.concatenate([chunk.end_attributes[name] for chunk in chunks]) for name in first.end_attributes},
        first.unit,
        first.metadata,
    )


def check_same(lines: fl.Lines, other: fl.Lines) -> None:
    """Compare all that two lines have, bit for bit."""
    for name in ("segments", "strands", "skipped"):
        assert np.array_equal(getattr(lines, name), getattr(other, name)), name
    assert (lines.radius is None) == (other.radius is None)
    if lines.radius is not None and other.radius is not None:
        assert lines.radius.shape == other.radius.shape
        assert np.array_equal(lines.radius, other.radius)
    for columns, others in ((lines.attributes, other.attributes), (lines.end_attributes, other.end_attributes)):
        assert list(columns) == list(others)
        for name, values in columns.items():
            assert (values.dtype, values.shape) == (others[name].dtype, others[name].shape), name
            same = values == others[name] if values.dtype == object else None
            assert np.array_equal(values, others[name], equal_nan=True) if same is None else same.all(), name
    assert facts_of(lines) == facts_of(other)


def facts_of(lines: fl.Lines) -> str:
    """Return what is known of lines beside arrays, in words: NaN equals NaN."""
    return repr((lines.up, lines.unit, lines.metadata))


def check_chunks(path: Path, max_segments: int = 7, **options: Any) -> list[fl.Lines]:
    """Check that the chunks of a file are the lines that `fl.read` returns, with the same warnings; return them."""
    whole, said = _told(lambda: [fl.read(path, **options).as_lines()])
    chunks, said_of_chunks = _told(lambda: fl.read_chunks(path, max_segments, **options))
    assert sorted(said_of_chunks) == sorted(said)
    check_same(joined(chunks), whole[0])
    for chunk in chunks:
        assert len(chunk) <= max_segments or not _can_be_cut(chunk.strands)
        assert facts_of(chunk) == facts_of(whole[0])
    return chunks


def _can_be_cut(strands: np.ndarray) -> bool:
    """Return whether there is a row from which on all strands are larger than those before."""
    numbers = strands[strands >= 0]
    edges = strands[0] < 0 or strands[-1] < 0
    return edges or any(numbers[:i].max() < numbers[i:].min() for i in range(1, len(numbers)))


def check_error(path: Path, max_segments: int = 7, **options: Any) -> str:
    """Check that reading chunks ends with the error of `fl.read`; return the error."""
    error = _error(lambda: [fl.read(path, **options)])
    assert error is not None
    found = _error(lambda: fl.read_chunks(path, max_segments, **options))
    assert found is not None
    if "segments hold" in found and "segments hold" not in error:  # they come before another fault
        return check_error(path, max_segments, **options | {"invalid": "skip"})
    assert _without_numbers(found) == _without_numbers(error)
    return error


def _without_numbers(error: str) -> str:
    """Leave out addresses, and the invalid rows: chunks count them up to their end, and not in the whole file."""
    return re.sub(r"\d+ of (the first )?\d+ segments hold (.*) \(.*?\)|0x[0-9a-f]+", r"\2", error)


def check_either(path: Path, max_segments: int = 7, **options: Any) -> None:
    """Check that chunks of a file, which may be damaged, are the lines or the error of `fl.read`."""
    if _error(lambda: [fl.read(path, **options)]) is None:
        check_chunks(path, max_segments, **options)
    else:
        check_error(path, max_segments, **options)


def _error(read: Callable[[], Iterable[Any]]) -> str | None:
    """Return the error with which reading ends; None if there is none."""
    try:
        _told(read)
    except (fl.FastlinesError, OSError) as error:
        return f"{type(error).__name__}: {error}"
    return None


def _told(read: Callable[[], Iterable[Any]]) -> tuple[list[Any], list[str]]:
    """Return what is read, and the warnings on the way."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        made = list(read())
    return made, [f"{warning.category.__name__}: {warning.message}" for warning in said]
