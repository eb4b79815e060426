"""Connections to the workers of Dask, by the address of their scheduler."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ...errors import InputError
from ...support.optional import optional
from ...threads import get_num_threads

#: The name of a scheduler on this machine, which is started and ends with its client.
LOCAL = "local"

#: How long to wait for a scheduler, in seconds.
PATIENCE = 10


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """Yield a client of the scheduler at an address, or of one on this machine: `LOCAL`.

    On this machine there are as many workers as fastlines uses threads, and each has one.

    Raises
    ------
    InputError
        If no scheduler answers there.
    MissingExtraError
        If the extra "cluster" is not installed.
    """
    distributed = optional("distributed", "Dask workers", "cluster")
    if address == LOCAL:
        with (
            distributed.LocalCluster(
                n_workers=get_num_threads(), threads_per_worker=1, dashboard_address=None, silence_logs=40
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError) as error:
        why = " ".join(str(error).split())[:120]
        raise InputError(
            f"no scheduler of Dask answers at {address!r} ({why}); expected an address such as tcp://host:8786, or "
            f"{LOCAL!r} for workers on this machine"
        ) from None
    with client:
        yield client
