"""Workers that are lost while they work: the answer is complete and the same, or there is one clear error."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.figures import Figures
from ..harness.findings import Check
from ..harness.internals import FastlinesError, optional
from . import streamlines
from .answers import most_segments
from .cluster import local_client
from .questions import RADIUS, columns_of, same

#: How long Dask waits for what does not answer. By default it is half a minute for a connection, and five minutes for a
#: silent worker.
PATIENCE = {
    "distributed.comm.timeouts.connect": "5s",
    "distributed.comm.timeouts.tcp": "15s",
    "distributed.scheduler.worker-ttl": "15s",
}


def run_kills(n_segments: int, n_tiles: int, n_rays: int, n_kills: int, progress: Any) -> Figures:
    """Kill one of two workers at a random moment of a query, so often; and cut one off from the scheduler."""
    distributed: Any = optional("distributed", "Dask workers", "cluster")
    dask: Any = optional("dask", "Dask workers", "cluster")
    rng = np.random.default_rng(35)
    counts = {"the same answer": 0, "one clear error": 0, "another answer": 0}
    with TemporaryDirectory(prefix="fastlines-bench-") as temporary, dask.config.set(PATIENCE):
        folder = Path(temporary) / "forest"
        source = streamlines.chunks(n_segments)
        forest = fl.build_forest(source, folder, max_segments=most_segments(n_segments, n_tiles))
        rays = streamlines.rays(n_rays)
        expected = columns_of(forest.first_hit(*rays, RADIUS))
        alone = slowest = 0.0
        for i in range(n_kills):
            progress(f"kills: {i + 1} of {n_kills}", i / n_kills)
            # A cluster of its own for each: after some kills, Dask may start no worker again.
            with local_client(distributed, 2) as client:
                on = forest.on(client)
                if i == 0:
                    on.first_hit(*rays, RADIUS)
                    begin = time.perf_counter()
                    on.first_hit(*rays, RADIUS)
                    alone = time.perf_counter() - begin
                pids = sorted(client.run(os.getpid).values())
                timer = threading.Timer(float(rng.uniform(0, 0.9)) * alone, _kill, [pids[int(rng.integers(2))]])
                begin = time.perf_counter()
                timer.start()
                counts[_verdict(on, rays, expected)] += 1
                slowest = max(slowest, time.perf_counter() - begin)
                timer.join()
        rows: list[tuple[Any, ...]] = [("a worker is killed", n_kills, *counts.values(), alone, slowest)]
        progress("kills: cut off", 0.95)
        rows += _cut_off(forest, rays, expected)
    heads = ("what", "times", *counts, "alone, s", "slowest, s")
    notes = [
        f"{n_rays:,} rays, {n_segments:,} segments in {n_tiles} tiles. Dask starts a killed worker again. A worker is "
        "cut off by taking the link of its network namespace down, which needs root and the command ip."
    ]
    wrong = sum(int(row[4]) for row in rows)
    checks = [Check("other or partial answers", float(wrong), 0.0)]
    return Figures("kills", "workers that are lost", heads, rows, notes, checks)


def _kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)


def _verdict(forest: Any, rays: Any, expected: Any) -> str:
    try:
        found = forest.first_hit(*rays, RADIUS)
    except FastlinesError:
        return "one clear error"
    return "the same answer" if same(expected, columns_of(found)) else "another answer"


def _cut_off(forest: Any, rays: Any, expected: Any) -> list[tuple[Any, ...]]:
    """Cut one of two workers off, in a network namespace of its own; nothing where that cannot be done."""
    from .namespace import Namespace

    if not Namespace.is_possible():
        return []
    distributed: Any = optional("distributed", "Dask workers", "cluster")
    counts = {"the same answer": 0, "one clear error": 0, "another answer": 0}
    with Namespace() as space, local_client(distributed, 1, host=space.host) as client:
        worker = space.start_worker(client.scheduler.address)
        try:
            client.wait_for_workers(2, timeout=300)
            on = forest.on(client)
            on.first_hit(*rays, RADIUS)
            begin = time.perf_counter()
            on.first_hit(*rays, RADIUS)
            alone = time.perf_counter() - begin
            timer = threading.Timer(0.3 * alone, space.cut)
            begin = time.perf_counter()
            timer.start()
            counts[_verdict(on, rays, expected)] += 1
            slowest = time.perf_counter() - begin
            timer.join()
        finally:
            worker.kill()
            worker.wait()
    return [("a worker is cut off", 1, *counts.values(), alone, slowest)]
