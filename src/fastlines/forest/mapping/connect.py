"""Clients of Dask by the address of a scheduler, as the command line takes it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
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
        If this is no address, or no scheduler answers there.
    """
    distributed = optional("distributed", "a scheduler of Dask", "cluster")
    if scheduler == "local":
        n_workers = get_num_threads()
        options = {"n_workers": n_workers, "threads_per_worker": 1, "dashboard_address": ":0"}
        with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster, set_as_default=False) as made:
            yield made
        return
    address = _address_in(Path(scheduler)) if scheduler.endswith(".json") else scheduler
    if not re.match(r"(\w+://)?[^/]*[^/]:\d", address):  # Dask would take a minute to end
        raise WorkerError(
            f"scheduler={address!r} is not an address; expected one such as tcp://10.0.0.1:8786, the .json file of "
            "dask scheduler --scheduler-file, or local"
        )
    try:
        made = distributed.Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        why = str(error).partition("\n")[0]
        raise WorkerError(
            f"no scheduler answers at {scheduler} ({why}); start one with dask scheduler, and workers with dask "
            "worker ADDRESS, or take local"
        ) from None
    with made:
        yield made


def _address_in(path: Path) -> str:
    """Return the address of the scheduler that has written a file; Dask would wait for one that is not there."""
    try:
        return str(json.loads(path.read_text(encoding="utf-8"))["address"])
    except FileNotFoundError:
        raise WorkerError(f"{path}: no such file; dask scheduler --scheduler-file {path} writes it") from None
    except (ValueError, TypeError, KeyError):
        raise WorkerError(
            f"{path}: holds no address of a scheduler; start dask scheduler --scheduler-file anew"
        ) from None
