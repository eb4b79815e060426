"""A query cut into tasks: sizes of chunks by measured cost, any `map`, and checks of what it returns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from ...arrays import IntArray, kind_of
from ...errors import FastlinesError, InputError, WorkerError
from ...progress import ProgressCallback
from .task import Done, Fault, MapFunction, Task, Work, do, installed_version


@dataclass(frozen=True)
class ChunkTuning:
    """Sizes of chunks, in rays or points, bytes and seconds."""

    #: How long a chunk should take: a cancelled query waits for those that run.
    seconds: float = 0.5
    #: The most bytes of a chunk, and of its answer: Dask keeps tasks for retries, and warns of tasks above 10 MB.
    n_bytes: int = 8_000_000
    #: The fewest rows of a chunk.
    least: int = 2048
    #: How many chunks each worker should get at least, so that all end at the same time.
    each: int = 4
    #: How many workers there are, where the map does not say.
    n_slots: int = 4
    #: From so many rows on, a first round measures what a row costs, with so many chunks.
    measured_from: int = 1 << 17
    n_measured: int = 8
    #: What a row is taken to cost before, in seconds and bytes.
    seconds_a_row: float = 5e-6
    bytes_a_row: float = 24.0


TUNING = ChunkTuning()

Columns = TypeVar("Columns")


@dataclass(frozen=True, eq=False)
class Chunk(Generic[Columns]):
    """Rows of a query, and their answer."""

    rows: IntArray
    answer: Columns


@dataclass(frozen=True, eq=False)
class Mapping:
    """Runs queries as tasks of a `map`."""

    function: MapFunction
    #: How many threads a task may use; None for its share of those of the worker.
    n_threads: int | None = None
    tuning: ChunkTuning = field(default=TUNING)

    def run(self, work: Sequence[Work], places: Sequence[float] | None = None) -> Iterator[Done]:
        """Run tasks, and yield what they return, in their order.

        Raises
        ------
        WorkerError
            If one fails; the others are cancelled.
        """
        version = installed_version()
        at = [i / max(1, len(work)) for i in range(len(work))] if places is None else places
        tasks = [Task(i, each, at[i], self.n_threads, version) for i, each in enumerate(work)]
        results = self._results(tasks)
        try:
            for task in tasks:
                yield self._next(results, task, len(tasks))
        finally:
            # What is left is cancelled by the end of the iteration, of executors and of Dask.
            if (close := getattr(results, "close", None)) is not None:
                close()

    def rows(
        self,
        tile: IntArray,
        n_tiles: int,
        make: Callable[[IntArray], Work],
        n_bytes: int,
        progress: ProgressCallback | None,
    ) -> Iterator[Chunk[Any]]:
        """Run a query of rows, sorted by tile and cut into chunks, and yield their answers.

        Parameters
        ----------
        tile : (n,) int64
            The tile of each row, of so many tiles; -1 leaves a row out.
        make
            Makes the work for some rows.
        n_bytes : int
            The bytes of all rows of the query.
        """
        order, row_bytes = rows_by_tile(tile), n_bytes / max(1, len(tile))
        if not len(order):
            return

        def place(rows: IntArray) -> float:
            """Return where the first tile of some rows is among all tiles, from 0 to 1."""
            return float(tile[rows[0]]) / n_tiles

        n_done, seconds, answer_bytes = 0, self.tuning.seconds_a_row, self.tuning.bytes_a_row
        for chunks in self._rounds(order):
            # Cut the last round by the measured cost.
            cut = chunks if len(chunks) > 1 else self._cut(chunks[0], seconds, max(row_bytes, answer_bytes))
            spent, returned, n_rows = 0.0, 0.0, 0
            for rows, done in zip(cut, self.run([*map(make, cut)], [*map(place, cut)]), strict=True):
                spent, returned, n_rows = spent + done.seconds, returned + _n_bytes(done.value), n_rows + len(rows)
                n_done += len(rows)
                yield Chunk(rows, done.value)
                if progress is not None:
                    progress(n_done / len(order))
            seconds, answer_bytes = spent / max(1, n_rows), returned / max(1, n_rows)

    @property
    def n_chunks(self) -> int:
        """How many chunks a query should have at least."""
        n_slots = int(getattr(self.function, "n_slots", 0)) or self.tuning.n_slots
        return self.tuning.each * n_slots

    def _rounds(self, order: IntArray) -> Iterator[list[IntArray]]:
        """Yield chunks all over the rows, which measure their cost, and then all others, as one."""
        n, tuning = len(order), self.tuning
        if n < tuning.measured_from:
            yield [order]
            return
        begins = np.arange(tuning.n_measured) * (n // tuning.n_measured)
        is_measured = np.zeros(n, bool)
        is_measured[(begins[:, None] + np.arange(tuning.least)).reshape(-1)] = True
        yield [order[begin : begin + tuning.least] for begin in begins.tolist()]
        yield [order[~is_measured]]

    def _cut(self, order: IntArray, seconds: float, n_bytes: float) -> list[IntArray]:
        """Cut rows, by what one costs."""
        tuning = self.tuning
        fitting = min(tuning.seconds / max(seconds, 1e-9), tuning.n_bytes / max(n_bytes, 1))
        size = max(1, min(fitting, max(tuning.least, len(order) / self.n_chunks)))
        return np.array_split(order, max(1, math.ceil(len(order) / size)))

    def _results(self, tasks: list[Task]) -> Iterator[Any]:
        try:
            return iter(self.function(do, tasks))
        except FastlinesError:
            raise
        except TypeError as error:
            raise InputError(
                f"the map failed: {error}; expected a function that takes a function and a list, as executor.map does"
            ) from None
        except Exception as error:
            raise _failed(error) from error

    def _next(self, results: Iterator[Any], task: Task, n_tasks: int) -> Done:
        try:
            result = next(results, None)
        except FastlinesError:
            raise
        except Exception as error:
            raise _failed(error) from error
        if isinstance(result, Fault):
            raise result.error()
        if not isinstance(result, Done) or result.number != task.number:
            raise InputError(
                f"the map returned {kind_of(result)} for task {task.number} of {n_tasks}; expected what the function "
                "returns for each task, in the order of the tasks, as executor.map does"
            )
        return result


def rows_by_tile(tile: IntArray) -> IntArray:
    """Return the rows that have a tile, sorted by it; rows of a tile keep their order."""
    narrow = tile.astype(np.uint16) if tile.max(initial=0) < 2**16 - 1 else tile  # NumPy sorts 16 bits by their digits
    order = np.argsort(narrow, kind="stable")
    n_none = int((tile < 0).sum())
    # Without a tile is -1, the largest number of 16 bits.
    return order[: len(order) - n_none] if narrow is not tile else order[n_none:]


def _failed(error: Exception) -> WorkerError:
    """Say that a map failed."""
    if isinstance(error, BrokenExecutor):
        return WorkerError(
            "a process of the executor has ended, killed perhaps for its memory; make a new executor, and query again: "
            "an executor cannot replace its processes, and the workers of Dask can"
        )
    return WorkerError(f"the map failed: {type(error).__name__}: {error}")


def _n_bytes(value: Any) -> int:
    """Return the bytes of arrays, which may be in tuples."""
    return sum(map(_n_bytes, value)) if isinstance(value, tuple | list) else int(getattr(value, "nbytes", 0))
