"""Dask workers beside the threads of one process: how long rays take, and where the time goes."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.figures import Figures
from ..harness.findings import Check
from ..harness.internals import num_threads, optional
from . import streamlines
from .answers import most_segments
from .questions import RADIUS, columns_of, same

#: The rays of a block of a dask array.
BLOCK = 1_000_000


def run_cluster(n_segments: int, n_tiles: int, n_rays: int, rounds: int, progress: Any) -> Figures:
    """Time first hits of random rays: by one process, and by one and by two workers of one thread each."""
    distributed = optional("distributed", "Dask workers", "cluster")
    with TemporaryDirectory(prefix="fastlines-bench-") as temporary, ExitStack() as stack:
        folder = Path(temporary) / "forest"
        progress("cluster: building", 0.0)
        source = streamlines.chunks(n_segments)
        forest = fl.build_forest(source, folder, max_segments=most_segments(n_segments, n_tiles))
        origins, directions = streamlines.rays(n_rays)
        clients = {n: stack.enter_context(local_client(distributed, n)) for n in (1, 2)}
        sides: dict[str, tuple[Callable[[], Any], Any]] = {
            f"one process, {n} thread{'s' if n > 1 else ''}": (_in_process(forest, n, origins, directions), None)
            for n in (1, 2)
        }
        for n, client in clients.items():
            workers = f"{n} worker{'s' if n > 1 else ''}"
            on = forest.on(client)
            sides[f"{workers}, NumPy arrays"] = (partial(on.first_hit, origins, directions, RADIUS), client)
            sides[f"{workers}, dask arrays"] = (_blocks(on, client, n_rays), client)
        expected = columns_of(forest.first_hit(origins, directions, RADIUS))
        times: dict[str, list[tuple[float, float, float]]] = {name: [] for name in sides}
        n_wrong = 0
        for i in range(rounds + 1):  # the first round opens the tiles and does not count
            for j, (name, (ask, client)) in enumerate(sides.items()):
                progress(f"cluster: {name}", (i + j / len(sides)) / (rounds + 1))
                before = _worker_seconds(client), time.process_time(), time.perf_counter()
                found = ask()
                wall, own = time.perf_counter() - before[2], time.process_time() - before[1]
                if i > 0:
                    times[name].append((wall, own, _worker_seconds(client) - before[0]))
                elif isinstance(found, fl.FirstHits):
                    n_wrong += not same(expected, columns_of(found))
    walls = {name: float(np.median([wall for wall, *_ in taken])) for name, taken in times.items()}
    rows = []
    for name, taken in times.items():
        _, own, work = (float(np.median(column)) for column in zip(*taken, strict=True))
        wall = walls[name]
        rows.append((name, n_rays, wall, n_rays / wall / 1e6, own, work, wall / walls["one process, 2 threads"]))
    heads = ("side", "rays", "seconds", "Mrays/s", "client, CPU s", "workers, CPU s", "beside two threads")
    notes = [
        f"{n_segments:,} segments in {n_tiles} tiles, medians of {rounds} alternated rounds after one that opens the "
        f"tiles. Dask arrays have blocks of {BLOCK:,} rays, which the workers make; answers stay there until they are "
        "summed up. With NumPy arrays rays and hits travel through the scheduler."
    ]
    checks = [
        Check(
            "two workers beside one, NumPy arrays",
            _ratio(walls, "2 workers, NumPy arrays", "1 worker, NumPy arrays"),
            0.6,
        ),
        Check(
            "two workers beside one, dask arrays", _ratio(walls, "2 workers, dask arrays", "1 worker, dask arrays"), 0.6
        ),
        Check(
            "two workers beside two threads, dask arrays",
            _ratio(walls, "2 workers, dask arrays", "one process, 2 threads"),
            1.15,
        ),
        Check(
            "two workers beside two threads, NumPy arrays",
            _ratio(walls, "2 workers, NumPy arrays", "one process, 2 threads"),
            1.15,
        ),
        Check("answers that differ", float(n_wrong), 0.0),
    ]
    return Figures("cluster", "first hits by Dask workers, beside one process", heads, rows, notes, checks)


def local_client(distributed: Any, n_workers: int, **more: Any) -> Any:
    """Return a client of a cluster on this machine, which ends with it."""
    cluster = distributed.LocalCluster(
        n_workers=n_workers, threads_per_worker=1, processes=True, dashboard_address=None, **more
    )
    return _Ending(distributed.Client(cluster), cluster)


class _Ending:
    """A client that closes its cluster, too."""

    def __init__(self, client: Any, cluster: Any) -> None:
        self.client, self.cluster = client, cluster

    def __enter__(self) -> Any:
        return self.client

    def __exit__(self, *_: object) -> None:
        self.client.close()
        self.cluster.close()


def _ratio(walls: dict[str, float], name: str, beside: str) -> float:
    return walls[name] / walls[beside]


def _in_process(forest: Any, n_threads: int, origins: Any, directions: Any) -> Callable[[], Any]:
    def ask() -> Any:
        with num_threads(n_threads):
            return forest.first_hit(origins, directions, RADIUS)

    return ask


def _blocks(forest: Any, client: Any, n_rays: int) -> Callable[[], Any]:
    """Return a call that makes rays in the workers, and returns how many of them hit."""
    array: Any = optional("dask.array", "Dask workers", "cluster")
    sizes = [min(BLOCK, n_rays - begin) for begin in range(0, n_rays, BLOCK)]

    def ask() -> Any:
        rays = [array.from_delayed(_rays_of(i, n), shape=(2, n, 3), dtype=np.float32) for i, n in enumerate(sizes)]
        whole = array.concatenate(rays, axis=1)
        hits = forest.first_hit(whole[0], whole[1], RADIUS)
        # Several clients are open, and `compute()` would use the last one.
        return int(client.compute((hits.prim >= 0).sum()).result())

    return ask


def _rays_of(seed: int, n: int) -> Any:
    dask: Any = optional("dask", "Dask workers", "cluster")
    return dask.delayed(lambda: np.stack(streamlines.rays(n, seed)))()


def _worker_seconds(client: Any) -> float:
    """Return the processor time of all workers."""
    return 0.0 if client is None else float(sum(client.run(_cpu_seconds).values()))


def _cpu_seconds() -> float:
    times = os.times()
    return times.user + times.system
