"""A task: a chunk of a query, which any process that sees the folder of the forest can answer.

Tasks and answers are plain data, so that any `map` can carry them. What goes wrong comes back as a `Fault`, not as an
exception: an exception that cannot be pickled would break a pool of processes.
"""

from __future__ import annotations

import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Protocol, TypeAlias

from ...errors import WorkerError
from ...threads import get_num_threads, threads_of_this_thread

#: What `map` is to do: call a function with each task, and return or yield what it returns, in the order of the tasks.
MapFunction: TypeAlias = Callable[[Callable[[Any], Any], Sequence[Any]], Any]


class Work(Protocol):
    """What a task does: a query of a chunk of rays or of points."""

    def done(self) -> Any:
        """Do the work in this process, and return arrays."""


@dataclass(frozen=True, eq=False)
class Task:
    """A chunk of a query."""

    #: Its number among the tasks of the call.
    number: int
    work: Work
    #: Where its first tile is among all tiles, from 0 to 1: near tasks share tiles, and workers keep these open.
    place: float = 0.0
    #: How many threads it may use; None for its share of those of the worker.
    n_threads: int | None = None
    #: The version of fastlines that made it.
    version: str = ""


@dataclass(frozen=True, eq=False)
class Done:
    """What a task returns."""

    number: int
    value: Any
    #: How long it took.
    seconds: float


@dataclass(frozen=True)
class Fault:
    """Why a process could not do a task."""

    #: The worker.
    where: str
    message: str

    def error(self) -> WorkerError:
        """Return the error to raise."""
        return WorkerError(f"{self.where}: {self.message}")


def installed_version() -> str:
    """Return the version of fastlines, and nothing for sources that are not installed."""
    try:
        return version("fastlines")
    except PackageNotFoundError:
        return ""


def do(task: Task) -> Done | Fault:
    """Do a task in this process."""
    if task.version != (here := installed_version()):
        given, own = (f"fastlines {each}" if each else "sources of fastlines" for each in (task.version, here))
        return Fault(this_worker(), f"has {own}, and the caller {given}; install the same version in both places")
    start = time.perf_counter()
    try:
        with _running.one_more() as n_running:
            n_threads = task.n_threads or max(1, _worker_threads() // n_running)
            with threads_of_this_thread(n_threads):
                value = task.work.done()
    except MemoryError as error:
        why = f" ({error})" if str(error) else ""
        return Fault(this_worker(), f"ran out of memory{why}; give it more, or run fewer tasks at a time there")
    except Exception as error:
        known = isinstance(error, OSError | ValueError) and str(error)
        return Fault(this_worker(), str(error) if known else f"{type(error).__name__}: {error}")
    return Done(task.number, value, time.perf_counter() - start)


def this_worker() -> str:
    """Return the name of this process: its address as a worker of Dask, or its host and number."""
    worker = _dask_worker()
    return f"worker {worker.address}" if worker is not None else f"process {os.getpid()} on {socket.gethostname()}"


def _worker_threads() -> int:
    """Return how many threads the tasks of this process share: those of a worker of Dask, or one for each task."""
    worker = _dask_worker()
    return 1 if worker is None else min(int(worker.state.nthreads), get_num_threads())


def _dask_worker() -> Any:
    """Return the worker of Dask that runs this task, or None."""
    if "distributed.worker" not in sys.modules:
        return None
    try:
        return sys.modules["distributed.worker"].get_worker()
    except ValueError:
        return None


@dataclass
class _Running:
    """Counts the tasks that run in this process."""

    n: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    @contextmanager
    def one_more(self) -> Iterator[int]:
        """Return how many tasks run, this one included."""
        with self.lock:
            self.n += 1
            n = self.n
        try:
            yield n
        finally:
            with self.lock:
                self.n -= 1


_running = _Running()
