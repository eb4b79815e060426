"""Calls in several threads: their order, their errors, their own number of threads, and an early end."""

from __future__ import annotations

import threading
import time
from functools import partial

import pytest
from support.patience import HANGS

import fastlines as fl
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


@pytest.mark.parametrize(
    ("n_threads", "n_items", "at_most", "each"),
    [(4, 8, 99, 1), (4, 8, 2, 2), (7, 3, 99, 2), (4, 1, 99, 4), (4, 8, 1, 4), (1, 8, 99, 1), (4, 0, 99, None)],
)
def test_calls_share_the_number_of_threads(n_threads, n_items, at_most, each):
    with num_threads(n_threads):
        assert list(map_in_threads(lambda _: get_num_threads(), range(n_items), at_most)) == [each] * n_items
        assert get_num_threads() == n_threads


def test_no_more_calls_at_a_time_than_allowed():
    now, most, lock = 0, 0, threading.Lock()

    def call(item):
        nonlocal now, most
        with lock:
            now += 1
            most = max(most, now)
        time.sleep(0.001)
        with lock:
            now -= 1
        return item

    with num_threads(8):
        assert list(map_in_threads(call, range(50), 3)) == list(range(50))
    assert most <= 3


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
    assert len(called) < 1000  # as soon as the error is noticed


def test_no_call_begins_after_an_early_end():
    called = []
    with num_threads(2):
        found = map_in_threads(partial(slow, called), range(10_000))
        assert next(found) == 0
        found.close()
    assert len(called) < 1000
    n_called = len(called)
    time.sleep(0.05)
    assert len(called) == n_called


def test_calls_that_nobody_waits_for_end_at_their_next_query():
    """One call fails while another one asks a tree over and over, which would go on forever."""
    tree, asks = fl.build([[[0, 0, 0], [1, 0, 0]]]), threading.Event()

    def call(index):
        if index == 0:
            assert asks.wait(HANGS)
            raise ValueError("the first call fails")
        for _ in iter(int, 1):
            tree.any_hit([0, 0, 1], [0, 0, -1], 0.1)
            asks.set()

    with num_threads(2), pytest.raises(ValueError, match="the first call fails"):
        list(map_in_threads(call, range(2)))
    assert tree.any_hit([0, 0, 1], [0, 0, -1], 0.1)
