"""Calls in several threads: their order, their errors, their own number of threads, and an early end."""

from __future__ import annotations

import threading
import time
from functools import partial

import pytest
from support.patience import HANGS

from fastlines.threads import get_num_threads, map_in_threads, num_threads


def test_results_come_in_the_order_of_the_items():
    last_is_done = threading.Event()

    def slow_at_first(item):
        if item == 0:
            assert last_is_done.wait(HANGS)
        if item == 2:
            last_is_done.set()
        return 10 * item

    with num_threads(3):
        assert list(map_in_threads(slow_at_first, range(3))) == [0, 10, 20]


@pytest.mark.parametrize(("n_threads", "n_items", "each"), [(4, 8, 1), (4, 1, 4), (1, 8, 1), (4, 0, None)])
def test_calls_within_use_one_thread_each(n_threads, n_items, each):
    with num_threads(n_threads):
        assert list(map_in_threads(lambda _: get_num_threads(), range(n_items))) == [each] * n_items
        assert get_num_threads() == n_threads


def slow(called, item):
    """Note a call that takes long enough for others to be stopped."""
    called.append(item)
    if item == 2:
        raise ValueError("two")
    time.sleep(0.01)
    return item


def test_no_call_begins_after_an_error():
    called = []
    with num_threads(2), pytest.raises(ValueError, match="two"):
        list(map_in_threads(partial(slow, called), range(10_000)))
    assert len(called) < 10_000


def test_no_call_begins_after_an_early_end():
    called = []
    with num_threads(2):
        found = map_in_threads(partial(slow, called), range(10_000))
        assert next(found) == 0
        found.close()
    assert len(called) < 10_000
    n_called = len(called)
    time.sleep(0.05)
    assert len(called) == n_called
