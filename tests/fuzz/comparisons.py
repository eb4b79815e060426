"""The same lines by other ways: from a file, packed, in chunks, written and read again, and by other packages."""

from __future__ import annotations

import gzip
import io
import tempfile
import warnings
import zlib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from claims import check_same, made_or_refused, require, same_bits, same_numbers, with_warnings
from support import line_chunks

import fastlines as fl
from fastlines.io import source, table
from fastlines.io.writing import parts_to_write

#: A comparison takes the name of a file, its bytes, the options with which they were read, and the lines.
Comparison = Callable[[str, bytes, dict[str, Any], Any], None]

#: Files have pieces of so many bytes, so that small ones have several.
PIECE = 97


@cache
def folder() -> Path:
    """Return a folder in memory where there is one; it goes with the process."""
    memory = Path("/dev/shm")
    kept = tempfile.TemporaryDirectory(prefix="fastlines-fuzz-", dir=memory if memory.is_dir() else None)
    folder.kept = kept  # type: ignore[attr-defined]
    return Path(kept.name)


def from_file(name: str, data: bytes, options: dict[str, Any], lines: Any) -> None:
    """Read the lines from a path."""
    path = folder() / name
    path.write_bytes(data)
    check_same(lines, fl.read(path, **options), "read from a path")


def packed(name: str, data: bytes, options: dict[str, Any], lines: Any) -> None:
    """Read the lines from a file that gzip has packed."""
    path = folder() / f"{name}.gz"
    path.write_bytes(gzip.compress(data, 1))
    check_same(lines, fl.read(path, **options), "read from a packed file")


def in_chunks(name: str, data: bytes, options: dict[str, Any], lines: Any) -> None:
    """Read the lines, or the error, in chunks, from a file of several pieces."""
    is_packed, size = data[-1] % 4 == 0, (1, 2, 7)[zlib.crc32(data) % 3]
    path = folder() / (f"{name}.gz" if is_packed else name)
    path.write_bytes(gzip.compress(data, 1) if is_packed else data)
    whole, source.PIECE = source.PIECE, PIECE
    try:
        line_chunks.check_either(path, size, **options)
    finally:
        source.PIECE = whole


def written(name: str, data: bytes, options: dict[str, Any], lines: Any) -> None:
    """Write the lines, and read them again; what the writer does not say that it loses is there."""
    row = table.named(Path(name).suffix)
    for part in parts_to_write(lines, row):
        path = folder() / f"written{row.extensions[0]}"
        # Formats of voxel grids make one up where there is none.
        has_grid = row.metadata == ("grid",)
        given = replace(part, metadata={}) if has_grid else part
        made = made_or_refused(lambda path=path, given=given: with_warnings(lambda: fl.write(path, given)))
        if isinstance(made, fl.FastlinesError):
            return
        lost = " ".join(made[1])
        back = fl.read(path)
        back = replace(back, metadata={}) if has_grid else back
        column = next(iter(given.sections))
        require(len(back) == len(given), f"{len(given)} rows are written, {len(back)} read")
        if not len(given):  # columns without rows have no place in most formats
            continue
        if row.name == "trk":  # whose points are in the millimetres of its voxels
            size = float(np.abs(getattr(given, column)).max(initial=0))
            near = np.allclose(getattr(back, column), getattr(given, column), rtol=0, atol=1e-5 * size + 1e-30)
            require(near, "points are moved by writing")
            continue
        if not lost:
            check_same(given, back, "written and read", same_numbers)
        elif "order of segments" not in lost and given.offset == back.offset:
            require(same_numbers(getattr(given, column), getattr(back, column)), "points are changed by writing")


def by_numpy(name: str, data: bytes, options: dict[str, Any], lines: Any) -> None:
    """Compare an array with what NumPy reads."""
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):
            array = np.load(io.BytesIO(data), allow_pickle=False).astype(np.float32)
    except (ValueError, TypeError, SyntaxError, EOFError, OverflowError, MemoryError):
        return
    if not len(lines.skipped):
        require(same_bits(array.reshape(-1, 2, 3), np.asarray(lines.segments)), "NumPy reads other numbers")


def by_nibabel(name: str, data: bytes, options: dict[str, Any], lines: Any) -> None:
    """Compare streamlines with those that NiBabel reads, of files that have no oddity."""
    path = folder() / name
    path.write_bytes(data)
    if with_warnings(lambda: fl.read(path, **options))[1]:
        return
    streamlines = import_module("nibabel.streamlines")
    kind = {".trk": streamlines.TrkFile, ".tck": streamlines.TckFile}[Path(name).suffix]
    try:
        with np.errstate(all="ignore"):
            found = kind.load(io.BytesIO(data), lazy_load=False).streamlines
    except Exception:  # it refuses more files, by errors of any kind
        return
    points = [np.asarray(strand, np.float64) for strand in found if len(strand)]
    if len(lines.skipped) or not len(points) or not all(np.isfinite(strand).all() for strand in points):
        return
    joined = [np.stack([p[:-1], p[1:]], axis=1) if len(p) > 1 else np.stack([p, p], axis=1) for p in points]
    expected, size = np.concatenate(joined), max(float(np.abs(p).max()) for p in points)
    require(len(expected) == len(lines), f"NiBabel reads {len(expected)} segments, not {len(lines)}")
    near = np.allclose(expected, lines.segments, rtol=0, atol=1e-4 * size)
    require(near, "NiBabel reads other points")
