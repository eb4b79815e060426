"""Tasks on workers of Dask: lost workers, faults of a cluster, and cancelling. Nothing hangs, and no half answer."""

from __future__ import annotations

import _thread
import asyncio
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass

import pytest
from support.patience import HANGS

from fastlines.errors import InputError, WorkerError
from fastlines.forest.mapping import dask_map, task
from fastlines.forest.mapping.connect import connected
from fastlines.forest.mapping.dask_map import DaskMap, is_client
from fastlines.forest.mapping.mapping import Mapping
from fastlines.forest.mapping.where import map_of
from fastlines.threads import num_threads

distributed = pytest.importorskip("distributed")


@dataclass(frozen=True)
class Square:
    number: int
    seconds: float = 0.0

    def done(self):
        time.sleep(self.seconds)
        return self.number**2


@dataclass(frozen=True)
class Process:
    seconds: float = 0.05

    def done(self):
        time.sleep(self.seconds)
        return os.getpid()


@dataclass(frozen=True)
class Killed:
    def done(self):
        os.kill(os.getpid(), signal.SIGKILL)


@dataclass(frozen=True)
class NotPickled:
    def done(self):
        return threading.Lock()


@dataclass(frozen=True)
class Failing:
    def done(self):
        raise OSError("no such folder")


def squares(n, seconds=0.0):
    return [Square(i, seconds) for i in range(n)]


def values(client, work, places=None):
    return [done.value for done in Mapping(DaskMap(client)).run(work, places)]


def test_results_come_in_the_order_of_the_tasks(client):
    assert is_client(client)
    assert not is_client(map)
    assert DaskMap(client).n_slots == 2
    assert values(client, squares(30)) == [i * i for i in range(30)]
    assert values(client, []) == []


def test_near_tasks_go_to_the_same_worker(client):
    values(client, squares(4))
    process = values(client, [Process()] * 16, [i / 16 for i in range(16)])
    # A worker that is done takes tasks of the other one, so this holds for most.
    half = [[each[0]] + [pid for pid in each if pid == each[0]] for each in (process[:8], process[8:])]
    assert half[0][0] != half[1][0]
    assert min(map(len, half)) >= 6
    # All places are those of one worker, and the other takes half of the tasks.
    process = values(client, [Process()] * 16, [0.0] * 16)
    assert 4 <= sum(each == process[0] for each in process) <= 12


def test_a_killed_worker_costs_only_its_tasks(client):
    results = Mapping(DaskMap(client)).run(squares(24, 0.05))
    found = [next(results).value]
    killed = next(iter(client.run(os.getpid).values()))
    os.kill(killed, signal.SIGKILL)
    found += [done.value for done in results]
    assert found == [i * i for i in range(24)]


def test_workers_that_end_with_a_task_are_named(client):
    client.run_on_scheduler(lambda dask_scheduler: setattr(dask_scheduler, "allowed_failures", 0))
    try:
        with pytest.raises(WorkerError, match=r"1 worker ended .* the last one tcp://.*out of memory"):
            values(client, [*squares(3), Killed()])
    finally:
        client.run_on_scheduler(lambda dask_scheduler: setattr(dask_scheduler, "allowed_failures", 3))


def test_a_fault_is_one_sentence_and_cancels_the_rest(client):
    with pytest.raises(WorkerError, match=r"^worker tcp://[\d.:]+: no such folder$"):
        values(client, [Failing(), *squares(200, 0.05)])
    assert_idle(client)
    assert values(client, squares(3)) == [0, 1, 4]


def test_a_result_that_cannot_be_sent_is_one_sentence(client):
    with pytest.raises(WorkerError, match=r"the scheduler at tcp://.* could not run a task: TypeError: [^\n]*$"):
        values(client, [NotPickled()])


def test_ctrl_c_cancels_the_tasks(client):
    threading.Timer(0.5, _thread.interrupt_main).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        values(client, squares(400, 0.1))
    assert time.monotonic() - start < HANGS
    assert_idle(client)


def assert_idle(client):
    """Wait until the scheduler knows no task."""
    until = time.monotonic() + HANGS
    while client.run_on_scheduler(lambda dask_scheduler: len(dask_scheduler.tasks)):
        assert time.monotonic() < until
        time.sleep(0.05)


def test_tasks_that_others_cancel(client):
    results = Mapping(DaskMap(client)).run(squares(40, 0.1))
    next(results)
    client.cancel([distributed.Future(key, client) for key in list(client.futures)], force=True)
    with pytest.raises(WorkerError, match=r"were cancelled, as client\.cancel and client\.restart do"):
        list(results)


def test_another_version_is_refused_before_any_work(client, monkeypatch):
    monkeypatch.setattr(dask_map, "installed_version", lambda: "9.9")
    with pytest.raises(
        WorkerError,
        match=r"has fastlines 9\.9, and the scheduler at tcp://.*, worker .* has .*; install",
    ):
        values(client, squares(2))
    monkeypatch.undo()
    monkeypatch.setattr(task, "installed_version", lambda: "9.9")
    monkeypatch.setattr("fastlines.forest.mapping.mapping.installed_version", lambda: "9.9")
    with pytest.raises(WorkerError, match=r"worker tcp://.*: has .*, and the caller fastlines 9\.9; install"):
        values(client, squares(2))


def test_a_client_that_is_closed(cluster):
    client = distributed.Client(cluster)
    client.close()
    with pytest.raises(WorkerError, match=r"the scheduler at .* does not answer \(the client is closed\); start it"):
        values(client, squares(2))


def test_an_asynchronous_client(cluster):
    async def ask():
        async with distributed.Client(cluster.scheduler_address, asynchronous=True) as client:
            with pytest.raises(InputError, match="where is an asynchronous Client"):
                map_of(client)

    asyncio.run(ask())


def test_a_scheduler_without_workers(monkeypatch):
    monkeypatch.setattr(dask_map, "NO_WORKER", 0.5)
    options = {"n_workers": 0, "processes": False, "dashboard_address": ":0"}
    with distributed.LocalCluster(**options) as empty, distributed.Client(empty) as client:
        with pytest.raises(WorkerError, match=r"has had no worker for 0\.5 s; start workers"):
            values(client, squares(2))
        monkeypatch.setattr(dask_map, "NO_WORKER", HANGS)
        threading.Timer(0.3, lambda: empty.scale(1)).start()
        assert values(client, squares(3)) == [0, 1, 4]


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_a_scheduler_that_is_gone_in_the_middle(tmp_path, monkeypatch, how):
    monkeypatch.setattr(dask_map, "PATIENCE", 3.0)
    file = str(tmp_path / "scheduler.json")
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard"]
    options = {"stderr": subprocess.DEVNULL, "env": {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}}
    scheduler = subprocess.Popen([*command, "--scheduler-file", file], **options)
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--no-dashboard", "--death-timeout", "30"]
    worker = subprocess.Popen([*worker, "--scheduler-file", file], **options)
    try:
        with distributed.Client(scheduler_file=file, timeout="60 s", set_as_default=False) as client:
            client.wait_for_workers(1, HANGS)
            results = Mapping(DaskMap(client)).run(squares(100, 0.1))
            assert next(results).value == 0
            scheduler.send_signal(how)
            with pytest.raises(WorkerError, match=r"the scheduler at tcp://.* does not answer \(.*\); start it again"):
                list(results)
            with pytest.raises(WorkerError, match=r"the scheduler at tcp://.* does not answer \(.*\); start it again"):
                values(client, squares(2))
            scheduler.kill()
    finally:
        for process in (scheduler, worker):
            process.kill()
            process.wait(HANGS)


def test_a_client_by_its_address(cluster, tmp_path):
    with connected(cluster.scheduler_address) as client:
        assert values(client, squares(3)) == [0, 1, 4]
    for address in ("tcp://127.0.0.1:9", "127.0.0.1:9", "nothing://here"):
        with pytest.raises(WorkerError, match=f"no scheduler answers at {address} .*; start one with  dask scheduler"):
            connected(address, 0.5).__enter__()
    with pytest.raises(WorkerError, match=r"there is no file .*nowhere.json; start a scheduler that writes it"):
        connected(str(tmp_path / "nowhere.json")).__enter__()


@pytest.mark.slow
def test_a_cluster_of_this_machine():
    with num_threads(1), connected("local") as client:
        assert values(client, squares(3)) == [0, 1, 4]
        assert DaskMap(client).n_slots == 1
