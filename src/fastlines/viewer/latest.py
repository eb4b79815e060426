"""Work of one thread, of which only the latest order of each kind is done: what a slider needs while it moves."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Latest:
    """A thread that carries out orders; one replaces an earlier one of the same kind that has not begun.

    Parameters
    ----------
    failed : callable
        Called with the error of an order, in the thread.

    Examples
    --------
    >>> done, gate = [], threading.Event()
    >>> worker = Latest(print)
    >>> worker.order("wait", gate.wait)
    >>> for radius in (1, 2, 3):
    ...     worker.order("radius", lambda radius=radius: done.append(radius))
    >>> gate.set()
    >>> worker.wait()
    >>> worker.close()
    >>> done
    [3]
    """

    def __init__(self, failed: Callable[[Exception], object]) -> None:
        self._failed = failed
        self._orders: dict[str, Callable[[], object]] = {}
        self._change = threading.Condition()
        self._is_open, self._is_busy = True, False
        self._thread = threading.Thread(target=self._work, daemon=True, name="fastlines viewer")
        self._thread.start()

    def order(self, kind: str, work: Callable[[], object]) -> None:
        """Order some work; it takes the place of an earlier order of its kind that has not begun."""
        with self._change:
            self._orders[kind] = work
            self._change.notify_all()

    def wait(self) -> None:
        """Wait until all orders are done, or the thread is closed; at once in the thread itself."""
        if threading.current_thread() is self._thread:
            return
        with self._change:
            self._change.wait_for(lambda: not self._is_open or not (self._orders or self._is_busy))

    def close(self) -> None:
        """End the thread after the order that it carries out."""
        with self._change:
            self._is_open = False
            self._orders.clear()
            self._change.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=5)

    def _work(self) -> None:
        while True:
            with self._change:
                self._is_busy = False
                self._change.notify_all()
                self._change.wait_for(lambda: not self._is_open or self._orders)
                if not self._is_open:
                    return
                work = self._orders.pop(next(iter(self._orders)))
                self._is_busy = True
            try:
                work()
            except Exception as error:
                self._failed(error)
