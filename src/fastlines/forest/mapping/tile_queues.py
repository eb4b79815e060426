"""Which worker does which task: workers keep near tiles open, and one that has nothing to do takes tasks of another."""

from __future__ import annotations

import bisect
from collections import deque
from collections.abc import Mapping, Sequence
from itertools import accumulate


class TileQueues:
    """A queue of tasks for each worker.

    Places of tasks are from 0 to 1, and so are the ranges of workers, as long as their numbers of threads. So a worker
    is given the same tiles by each query, whatever rays it has.

    Examples
    --------
    >>> queues = TileQueues([0, 0.1, 0.2, 0.9], {"a": 1, "b": 1})
    >>> [queues.take(worker) for worker in "abbaa"]
    [0, 3, 2, 1, None]
    """

    def __init__(self, places: Sequence[float], n_threads: Mapping[str, int]) -> None:
        workers = sorted(n_threads)
        self._queues: dict[str, deque[int]] = {worker: deque() for worker in workers}
        ends = list(accumulate(n_threads[worker] for worker in workers))
        for number in sorted(range(len(places)), key=lambda number: places[number]):
            worker = workers[min(bisect.bisect(ends, places[number] * ends[-1]), len(workers) - 1)]
            self._queues[worker].append(number)

    def take(self, worker: str) -> int | None:
        """Return the next task of a worker, which may be new; where it has none, the last one of the longest queue."""
        own = self._queues.get(worker)
        if own:
            return own.popleft()
        longest = max(self._queues.values(), key=len)
        return longest.pop() if longest else None
