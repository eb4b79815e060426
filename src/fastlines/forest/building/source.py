"""Sources of forests: files, iterators of chunks, dask arrays, and lines in memory; each as chunks of lines."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import kind_of
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...geometry.foreign import lines
from ...geometry.lines import Lines
from ...geometry.to_array import to_array
from ...io.chunks import read_chunks
from ...io.reading import check_path
from ...progress import ProgressCallback

#: The facts of chunks, which are known only once they are read.
STREAM = ["chunks"]


@dataclass(frozen=True)
class Reading:
    """How a source is read.

    Attributes
    ----------
    n_rows : int
        A chunk has at most this many segments, where the source can be cut.
    offset, invalid
        As in `fastlines.read`.
    progress : callable, optional
        Takes the fraction of an item that is read.
    """

    n_rows: int
    offset: Any
    invalid: str
    progress: ProgressCallback | None = None


@dataclass(frozen=True)
class Source:
    """Where lines come from.

    Attributes
    ----------
    facts : list
        What identifies the source, ready for JSON.
    items : sequence of callables
        Each takes a `Reading` and returns an iterator of lines. Reading can begin at each of them.
    """

    facts: list[Any]
    items: Sequence[Callable[[Reading], Iterator[Lines]]]

    @property
    def is_stream(self) -> bool:
        """Whether `facts` do not tell one source from another."""
        return self.facts == STREAM


def source_of(given: Any) -> Source:
    """Return the source that an argument of `build_forest` stands for.

    Raises
    ------
    InputError
        If it is none.
    OSError
        If a file cannot be read.
    """
    is_list = isinstance(given, list | tuple)
    if (is_list and not given) or given is None or isinstance(given, bool | int | float):
        raise InputError(
            f"source is {'empty' if is_list else repr(given)}; expected a file, several files, a folder of Parquet "
            "files, an iterator of chunks, an array of Dask, or lines"
        )
    if isinstance(given, str | os.PathLike):
        return _of_files([given])
    if is_list and all(isinstance(part, str | os.PathLike) for part in given):
        return _of_files(given)
    if hasattr(given, "__dask_graph__"):
        return _of_dask(given)
    several = all(map(_is_chunk, given)) if is_list else isinstance(given, Iterable)
    if not several or isinstance(given, AnyGeometry) or hasattr(given, "__array__"):
        given = [given]
    return Source(STREAM, [partial(_of_chunks, given)])


def _is_chunk(part: Any) -> bool:
    """Return whether a part of a list is a chunk: lines, segments, or polylines that differ in length."""
    try:
        return isinstance(part, AnyGeometry) or np.ndim(part) == 3
    except ValueError:
        return True


def _of_files(paths: Sequence[str | os.PathLike[str]]) -> Source:
    return Source([_file_facts(Path(path)) for path in paths], [partial(_of_file, path) for path in paths])


def _file_facts(path: Path) -> dict[str, Any]:
    """Return what tells that a file has changed: its size and time; of a folder, those of all files in it."""
    check_path(path)
    files = sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
    found = [file.stat() for file in files]
    facts = {"path": os.path.abspath(path), "bytes": sum(of.st_size for of in found)}
    return (
        facts
        | {"modified_ns": max((of.st_mtime_ns for of in found), default=0)}
        | ({"n_files": len(files)} if path.is_dir() else {})
    )


def _of_file(path: str | os.PathLike[str], how: Reading) -> Iterator[Lines]:
    return read_chunks(path, how.n_rows, offset=how.offset, invalid=how.invalid, progress=how.progress or False)


def _of_dask(array: Any) -> Source:
    """Return a dask array (n, 2, 3) as a source whose items are its blocks."""
    if array.ndim != 3 or array.shape[1:] != (2, 3):
        raise InputError(f"the dask array has shape {array.shape}; expected (n, 2, 3): n segments, both ends, x y z")
    array = array.rechunk({1: -1, 2: -1})
    facts = {"dask": array.name, "blocks": array.numblocks[0], "dtype": str(array.dtype)}
    return Source([facts], [partial(_of_block, array, i) for i in range(array.numblocks[0])])


def _of_block(array: Any, number: int, how: Reading) -> Iterator[Lines]:
    return _of_chunks([array.blocks[number].compute()], how)


def _of_chunks(chunks: Iterable[Any], how: Reading) -> Iterator[Lines]:
    """Return chunks as lines; arrays are cut."""
    offset = how.offset
    for number, chunk in enumerate(chunks):
        for begin, part in _cut(_usable(chunk), how.n_rows):
            try:
                made = lines(part, offset=offset, invalid=how.invalid)
            except InputError as error:
                where = f" from row {begin} on" if begin else ""
                raise InputError(f"chunk {number}{where}: {error}") from None
            if offset is not None:
                offset = made.offset
            yield made


def _usable(chunk: Any) -> Any:
    """Return a chunk that is lines, an array, or what `lines` takes."""
    if isinstance(chunk, str | os.PathLike):
        raise InputError(f"a chunk is {str(chunk)!r}, the name of a file; pass files as one path, or a list of paths")
    if not isinstance(chunk, AnyGeometry):
        return to_array(chunk)
    if (found := chunk.as_lines()) is None:
        raise InputError(f"a chunk is {kind_of(chunk)}; expected Lines, segments (n, 2, 3), or polylines")
    return found


def _cut(chunk: Any, n_rows: int) -> Iterator[tuple[int, Any]]:
    """Cut an array of segments; return the first row of each piece, and the piece."""
    if not isinstance(chunk, np.ndarray) or chunk.ndim < 2 or len(chunk) <= n_rows:
        yield 0, chunk
        return
    for begin in range(0, len(chunk), n_rows):
        yield begin, chunk[begin : begin + n_rows]
