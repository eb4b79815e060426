"""Clients of Dask by the address of a scheduler, as the command line takes it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ...errors import WorkerError
from ...support.optional import optional
from ...threads import get_num_threads

#: How long a scheduler may take to answer, in seconds.
TIMEOUT = 30.0


@contextmanager
def connected(scheduler: str, timeout: float = TIMEOUT) -> Iterator[Any]:
    """Return a client of a scheduler, for a while.

    Parameters
    ----------
    scheduler : str
        The address of a scheduler, such as ``tcp://10.0.0.1:8786``; the path of a file of ``dask scheduler
        --scheduler-file``, which ends in .json; or "local" for a process on this machine for each thread of fastlines.
    timeout : float
        How long it may take to answer, in seconds.

    Raises
    ------
    WorkerError
        If no scheduler answers there, or there is no such file.
    """
    distributed = optional("distributed", "workers of Dask", "cluster")
    if scheduler == "local":
        n_workers = get_num_threads()
        options = {"n_workers": n_workers, "threads_per_worker": 1, "dashboard_address": ":0"}
        with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster, set_as_default=False) as made:
            yield made
        return
    is_file = scheduler.endswith(".json")
    if is_file and not os.path.isfile(scheduler):  # a client would wait for it without end
        raise WorkerError(
            f"there is no file {scheduler}; start a scheduler that writes it, with  dask scheduler --scheduler-file "
            f"{scheduler}"
        )
    where = {"scheduler_file": scheduler} if is_file else {"address": scheduler}
    try:
        made = distributed.Client(**where, timeout=timeout, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        why = str(error).partition("\n")[0]
        raise WorkerError(
            f"no scheduler answers at {scheduler} ({why}); start one with  dask scheduler  and workers with  dask "
            "worker ADDRESS, or take local"
        ) from None
    with made:
        yield made
