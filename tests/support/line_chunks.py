"""Chunks of lines, joined as their strands and rows count on."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
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
    assert (lines.up, lines.unit, lines.metadata) == (other.up, other.unit, other.metadata)


def check_chunks(path: Path, max_segments: int = 7, **options: Any) -> list[fl.Lines]:
    """Check that the chunks of a file are the lines that `fl.read` returns, with the same warnings; return them."""
    whole, said = _told(lambda: [fl.read(path, **options).as_lines()])
    chunks, said_of_chunks = _told(lambda: fl.read_chunks(path, max_segments, **options))
    assert sorted(said_of_chunks) == sorted(said)
    check_same(joined(chunks), whole[0])
    for chunk in chunks:
        alone = len(np.unique(chunk.strands)) == 1 and (chunk.strands >= 0).all()
        assert len(chunk) <= max_segments or alone
        assert (chunk.up, chunk.unit, chunk.metadata) == (whole[0].up, whole[0].unit, whole[0].metadata)
    return chunks


def check_error(path: Path, max_segments: int = 7, **options: Any) -> str:
    """Check that reading chunks ends with the error of `fl.read`; return the error."""
    errors = []
    for read in (lambda: [fl.read(path, **options)], lambda: fl.read_chunks(path, max_segments, **options)):
        try:
            _told(read)
        except (fl.FastlinesError, OSError) as error:
            errors.append(f"{type(error).__name__}: {error}")
    assert len(errors) == 2
    assert errors[0] == errors[1]
    return errors[0]


def _told(read: Any) -> tuple[list[Any], list[str]]:
    """Return what is read, and the warnings on the way."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found: Iterable[Any] = read()
        made = list(found)
    return made, [f"{warning.category.__name__}: {warning.message}" for warning in said]
