"""A cluster of two processes, which all tests of a session share."""

from __future__ import annotations

import pytest
from support.patience import HANGS


@pytest.fixture(scope="session")
def cluster():
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0"}
    with distributed.LocalCluster(**options) as cluster:
        yield cluster


@pytest.fixture
def client(cluster):
    distributed = pytest.importorskip("distributed")
    with distributed.Client(cluster) as client:
        try:
            client.wait_for_workers(2, 60)
        except TimeoutError:  # a worker that a test has killed has not come back
            client.restart(wait_for_workers=False)
            client.wait_for_workers(2, HANGS)
        yield client
