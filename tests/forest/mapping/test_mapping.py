"""Tasks of any map: their order, their chunks, their faults, and their threads."""

from __future__ import annotations

import os
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pytest
from support.patience import HANGS

from fastlines.errors import FileFormatError, InputError, WorkerError
from fastlines.forest.mapping import task
from fastlines.forest.mapping.mapping import TUNING, ChunkTuning, Mapping
from fastlines.forest.mapping.task import do
from fastlines.forest.mapping.tile_queues import TileQueues
from fastlines.forest.mapping.where import mapping_of
from fastlines.threads import get_num_threads, num_threads


@dataclass(frozen=True)
class Square:
    numbers: np.ndarray

    def done(self):
        return self.numbers**2


@dataclass(frozen=True)
class Failing:
    error: BaseException

    def done(self):
        raise self.error


@dataclass(frozen=True)
class Killed:
    def done(self):
        os._exit(1)


@dataclass(frozen=True)
class Threads:
    def done(self):
        return get_num_threads()


def squares(n):
    return [Square(np.arange(i, i + 3)) for i in range(n)]


def test_results_come_in_the_order_of_the_tasks():
    with ThreadPoolExecutor(3) as executor:
        for function in (map, executor.map):
            found = [done.value.tolist() for done in Mapping(function).run(squares(20))]
            assert found == [[i * i, (i + 1) ** 2, (i + 2) ** 2] for i in range(20)]


def test_processes_answer_tasks():
    with ProcessPoolExecutor(1) as executor:
        assert [done.value[0] for done in Mapping(executor.map).run(squares(3))] == [0, 1, 4]


@pytest.mark.parametrize("n", [1, 5, 100, 3000])
def test_each_row_is_in_one_chunk(n):
    tuning = ChunkTuning(least=10, measured_from=200, n_measured=3)
    tile = np.random.default_rng(n).integers(0, 7, n)
    tile[1::3] = -1
    done, seen = [], []
    chunks = Mapping(map, tuning=tuning).rows(tile, 7, Square, 24 * n, done.append)
    for chunk in chunks:
        assert np.array_equal(chunk.answer, chunk.rows**2)
        assert (np.diff(tile[chunk.rows]) >= 0).all()
        seen.append(chunk.rows)
    assert np.array_equal(np.sort(np.concatenate(seen)), np.flatnonzero(tile >= 0))
    assert done == sorted(done)
    assert done[-1] == 1


def test_chunks_take_the_time_and_the_memory_of_the_tuning():
    mapping = Mapping(map, tuning=replace(TUNING, seconds=0.1, n_bytes=10_000))
    order = np.arange(1 << 16)
    sizes = [len(rows) for rows in mapping._cut(order, 1e-4, 1)]
    assert 900 < max(sizes) <= 1000
    assert max(len(rows) for rows in mapping._cut(order, 1e-9, 20)) <= 500
    assert len(mapping._cut(order, 1e-9, 0)) == TUNING.each * TUNING.n_slots
    assert len(mapping._cut(order[:100], 1e-9, 0)) == 1


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (FileFormatError("tile-00001.flt is missing; build again"), "tile-00001.flt is missing; build again"),
        (MemoryError(), "ran out of memory; give it more"),
        (KeyError("x"), "KeyError: 'x'"),
    ],
)
def test_a_fault_of_a_worker_is_one_sentence_that_names_it(error, said):
    with pytest.raises(WorkerError, match=f"process {os.getpid()} on .*: ") as raised:
        list(Mapping(map).run([*squares(2), Failing(error)]))
    assert said in str(raised.value)


def test_a_fault_cancels_the_tasks_that_have_not_begun():
    begun, gate = [], threading.Event()

    @dataclass(frozen=True)
    class Waiting:
        number: int

        def done(self):
            begun.append(self.number)
            if self.number == 0:
                raise OSError("no such folder")
            assert gate.wait(HANGS)

    with ThreadPoolExecutor(2) as executor:
        with pytest.raises(WorkerError, match="no such folder"):
            list(Mapping(executor.map).run([Waiting(i) for i in range(9)]))
        gate.set()
    assert len(begun) < 5


def test_a_pool_that_has_lost_a_process_says_so():
    with ProcessPoolExecutor(1) as executor, pytest.raises(WorkerError, match="a process of the executor has ended"):
        list(Mapping(executor.map).run([Killed(), *squares(2)]))


def test_another_version_is_refused(monkeypatch):
    mapping = Mapping(lambda function, tasks: [do(replace(each, version="0.0.1")) for each in tasks])
    with pytest.raises(WorkerError, match=r"the caller fastlines 0\.0\.1; install the same version"):
        list(mapping.run(squares(1)))
    monkeypatch.setattr(task, "installed_version", lambda: "")
    with pytest.raises(WorkerError, match="has sources of fastlines, and the caller"):
        list(Mapping(map).run(squares(1)))


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda function, tasks: [function(each) for each in tasks[::-1]], "in the order of the tasks"),
        (lambda function, tasks: [function(each) for each in tasks[:1]], "returned a NoneType for task 1 of 3"),
        (lambda function: [], "the map failed: .* takes 1 positional argument"),
    ],
)
def test_what_is_no_map_is_refused(function, said):
    with pytest.raises(InputError, match=said):
        list(Mapping(function).run(squares(3)))


def test_where_must_be_a_map():
    with pytest.raises(InputError, match=r"where=\[\]; expected a function, such as executor\.map, or a Client"):
        mapping_of([], None)
    with pytest.raises(InputError, match="n_threads=0; expected a whole number"):
        mapping_of(map, 0)


def test_tasks_have_one_thread_unless_they_are_given_more():
    with num_threads(4):
        assert [done.value for done in Mapping(map).run([Threads()])] == [1]
        assert [done.value for done in Mapping(map, 3).run([Threads()])] == [3]
        assert get_num_threads() == 4


def test_workers_are_given_near_tasks_and_take_those_of_others():
    places = [i / 12 for i in range(12)]
    queues = TileQueues(places, {"a": 1, "b": 2})
    assert [queues.take("a") for _ in range(4)] == [0, 1, 2, 3]
    assert [queues.take("b") for _ in range(3)] == [4, 5, 6]
    # Worker a has nothing left, and takes what b would do last; so does a worker that is new.
    assert [queues.take("a"), queues.take("new"), queues.take("b")] == [11, 10, 7]
    assert [queues.take("b") for _ in range(3)] == [8, 9, None]
