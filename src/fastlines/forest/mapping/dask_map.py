"""Tasks on the workers of Dask: near tiles on the same worker, lost workers, faults of the cluster, and cancelling.

Each task is a graph of its own, which the scheduler keeps until the task is done. So a task whose worker is lost runs
again on another one. Each worker is given a few tasks more than it has threads.
"""

from __future__ import annotations

import asyncio
import contextlib
import queue
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...errors import WorkerError
from ...support.texts import counted, listed
from .task import installed_version
from .tile_queues import TileQueues

#: How many tasks a worker has besides those that it runs, so that it need not wait for the next.
AHEAD = 2
#: How often to look whether the scheduler and workers are still there, in seconds.
LOOK = 0.2
#: How long to wait for a worker where there is none: clusters start workers for waiting tasks.
NO_WORKER = 60.0
#: How long a scheduler may take to answer.
PATIENCE = 30.0


def is_client(where: object) -> bool:
    """Return whether something is a client of Dask, without importing Dask."""
    return any(f"{kind.__module__}.{kind.__name__}" == "distributed.client.Client" for kind in type(where).__mro__)


@dataclass(frozen=True, eq=False)
class DaskMap:
    """The map of a client of Dask: it calls a function with each task on the workers, as `map` does here."""

    client: Any
    #: The workers whose version is known to be that of this process.
    _checked: set[str] = field(default_factory=set)

    def __call__(self, function: Callable[[Any], Any], tasks: Sequence[Any]) -> Iterator[Any]:
        """Yield what the function returns for each task, in the order of the tasks.

        Tasks that are not done when the iteration ends are cancelled.
        """
        if tasks:
            self._check_versions()
            yield from _Call(self, function, tasks).results()

    @property
    def n_slots(self) -> int:
        """How many tasks run at a time."""
        return sum(self.workers().values())

    @property
    def scheduler(self) -> str:
        """What the scheduler is called in errors."""
        return f"the scheduler at {getattr(self.client.scheduler, 'address', 'an unknown address')}"

    def workers(self) -> dict[str, int]:
        """Return the number of threads of each worker, by its address."""
        found: dict[str, int] = self._query_scheduler("ncores")
        return found

    def _query_scheduler(self, what: str, **options: Any) -> Any:
        """Query the scheduler, and say where it does not answer."""
        self.check_running()
        try:
            return self.client.sync(getattr(self.client.scheduler, what), callback_timeout=PATIENCE, **options)
        except (OSError, TimeoutError, asyncio.CancelledError, RuntimeError, AttributeError) as error:
            raise self.lost(str(error) or type(error).__name__) from None

    def check_running(self) -> None:
        """Raise an error if there is no scheduler."""
        if self.client.status != "running":
            raise self.lost(f"the client is {self.client.status}")

    def lost(self, why: str) -> WorkerError:
        """Say that the scheduler is not there."""
        return WorkerError(
            f"{self.scheduler} does not answer ({why}); start it again, connect with a new Client, and query again"
        )

    def _check_versions(self) -> None:
        """Refuse a cluster with another version of fastlines; query each worker once."""
        new = sorted(self.workers().keys() - self._checked)
        if not new and self._checked:
            return
        packages = ["fastlines"]
        message = {"op": "versions", "packages": packages}
        found = {self.scheduler: self._query_scheduler("versions", packages=packages)}
        if new:
            answers = self._query_scheduler("broadcast", msg=message, workers=new, on_error="ignore")
            found |= {f"worker {worker}": facts for worker, facts in answers.items()}
        here = installed_version()
        others = {
            where: facts["packages"].get("fastlines") or "none"
            for where, facts in found.items()
            if isinstance(facts, dict) and (facts["packages"].get("fastlines") or "") != here
        }
        if others:
            has = listed((f"{where} has {which}" for where, which in others.items()), most=3)
            raise WorkerError(
                f"this process has fastlines {here or 'from sources'}, and {has}; install the same version everywhere"
            )
        self._checked.update(new)


class _Call:
    """One call of a `DaskMap`."""

    def __init__(self, dask_map: DaskMap, function: Callable[[Any], Any], tasks: Sequence[Any]) -> None:
        self._map, self._client = dask_map, dask_map.client
        self._function, self._tasks = function, tasks
        self._workers: dict[str, int] = {}
        self._queues: TileQueues | None = None
        self._on: dict[int, str] = {}
        self._futures: dict[int, Any] = {}
        self._ended: queue.SimpleQueue[tuple[int, Any]] = queue.SimpleQueue()
        self._seen_worker = time.monotonic()

    def results(self) -> Iterator[Any]:
        """Yield results in the order of the tasks; cancel what is left at the end."""
        found: dict[int, Any] = {}
        try:
            self._wait_for_worker()
            for number in range(len(self._tasks)):
                while number not in found:
                    self._submit()
                    for ended, value in self._wait():
                        del self._futures[ended], self._on[ended]
                        found[ended] = value
                yield found.pop(number)
        finally:
            self._cancel()

    def _wait_for_worker(self) -> None:
        self._look()
        while not self._workers:
            time.sleep(LOOK)
            self._look()
        places = [getattr(task, "place", i / len(self._tasks)) for i, task in enumerate(self._tasks)]
        self._queues = TileQueues(places, self._workers)

    def _look(self) -> None:
        """Find the workers that there are."""
        self._workers = self._map.workers()
        now = time.monotonic()
        if self._workers:
            self._seen_worker = now
        elif now > self._seen_worker + NO_WORKER:
            raise WorkerError(
                f"{self._map.scheduler} has had no worker for {NO_WORKER:g} s; start workers, as with  dask worker "
                "ADDRESS, and query again"
            )

    def _submit(self) -> None:
        """Give each worker tasks."""
        assert self._queues is not None
        running = list(self._on.values())
        for worker, n_threads in self._workers.items():
            for _ in range(running.count(worker), n_threads + AHEAD):
                if (number := self._queues.take(worker)) is None:
                    return
                self._start(number, worker)

    def _start(self, number: int, worker: str) -> None:
        """Submit a task, whose result is fetched as soon as it is there."""
        where = {"workers": [worker], "allow_other_workers": True}
        future = self._client.submit(self._function, self._tasks[number], pure=False, **where)
        self._futures[number], self._on[number] = future, worker
        fetched = asyncio.run_coroutine_threadsafe(
            self._client.gather(future, asynchronous=True), self._client.loop.asyncio_loop
        )
        fetched.add_done_callback(lambda fetched: self._ended.put((number, fetched)))

    def _wait(self) -> list[tuple[int, Any]]:
        """Return the results of the tasks that have ended, at least one unless nothing has ended for a while."""
        try:
            ended = [self._ended.get(timeout=LOOK)]
        except queue.Empty:
            self._look()
            return []
        with contextlib.suppress(queue.Empty):
            while True:
                ended.append(self._ended.get_nowait())
        return [(number, self._value(fetched)) for number, fetched in ended]

    def _value(self, fetched: Any) -> Any:
        try:
            return fetched.result()
        except (Exception, asyncio.CancelledError) as error:
            raise self._fault(error) from None

    def _fault(self, error: BaseException) -> WorkerError:
        """Say why a task has no result."""
        kind, text = type(error).__name__, str(error).partition("\n")[0]
        reason = getattr(error, "reason", "")
        if self._client.status != "running" or reason == "scheduler-connection-lost":
            return self._map.lost("it has ended, or the network between")
        if isinstance(error, asyncio.CancelledError) or kind == "FutureCancelledError":
            return WorkerError(
                "the tasks of this query were cancelled, as client.cancel and client.restart do; query again"
            )
        if kind == "KilledWorker":
            last = getattr(getattr(error, "last_worker", None), "address", "of an unknown address")
            n_workers = counted(int(getattr(error, "allowed_failures", 3)) + 1, "workers")
            return WorkerError(
                f"{n_workers} ended while running the same task, the last one {last}; look into their logs, as "
                "a worker that runs out of memory is killed"
            )
        return WorkerError(f"{self._map.scheduler} could not run a task: {kind}: {text}")

    def _cancel(self) -> None:
        """Cancel what has not ended."""
        left = list(self._futures.values())
        self._futures.clear()
        if left and self._client.status == "running":
            with contextlib.suppress(OSError, TimeoutError, RuntimeError, asyncio.CancelledError):
                self._client.cancel(left)
