"""Forests that tasks build: the same bytes, whoever builds the tiles."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest

import fastlines as fl


def lines(n: int = 3000) -> fl.Lines:
    ends = np.random.default_rng(0).uniform(0, 1, (n, 1, 3)) + np.random.default_rng(1).normal(0, 0.02, (n, 2, 3))
    return fl.Lines.from_segments(ends.astype(np.float32))


def test_workers_of_dask_build_the_same_bytes(tmp_path, client):
    alone = fl.build_forest(lines(), tmp_path / "alone", max_segments=300)
    killed = []

    def kill(share):
        if share > 0.5 and not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    forest = fl.build_forest(lines(), tmp_path / "dask", max_segments=300, map=client, progress=kill)
    assert killed
    assert forest.n_tiles > 8
    for path in alone.path.iterdir():
        assert path.read_bytes() == (forest.path / path.name).read_bytes(), path.name


def test_a_worker_that_does_not_see_the_folder(tmp_path):
    def elsewhere(function, tasks):
        (tmp_path / "forest" / ".building").rename(tmp_path / "forest" / "hidden")
        return map(function, tasks)

    with pytest.raises(fl.WorkerError, match=r"^process .*: .*"):
        fl.build_forest(lines(), tmp_path / "forest", max_segments=300, map=elsewhere)
