"""Where tasks run: in a `map` of the caller's, or on the workers of Dask."""

from __future__ import annotations

from typing import Any

from ...arrays import count
from ...errors import InputError
from ...threads import MAX_THREADS
from .dask_map import DaskMap, is_client
from .mapping import Mapping
from .task import MapFunction


def map_of(where: Any, name: str = "where") -> MapFunction:
    """Return the map of a client of Dask, or the one that is given.

    Raises
    ------
    InputError
        If it is neither.
    """
    if is_client(where):
        if where.asynchronous:
            raise InputError(f"{name} is an asynchronous Client, and queries wait for their answers; pass another one")
        return DaskMap(where)
    if not callable(where):
        raise InputError(
            f"{name}={where!r}; expected a function, such as executor.map, or a Client of dask.distributed"
        )
    function: MapFunction = where
    return function


def mapping_of(where: Any, n_threads: int | None, name: str = "where") -> Mapping:
    """Check where tasks are to run, and with how many threads each."""
    return Mapping(map_of(where, name), None if n_threads is None else count("n_threads", n_threads, 1, MAX_THREADS))
