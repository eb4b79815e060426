"""Where tasks run: in a `map` of the caller's, or on the workers of Dask."""

from __future__ import annotations

from typing import Any

from ...arrays import count, kind_of
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
        return DaskMap(where)
    if not callable(where):
        raise InputError(
            f"{name} is {kind_of(where)}; expected a function such as the `map` of an executor, or a Client of "
            "dask.distributed"
        )
    function: MapFunction = where
    return function


def mapping_of(where: Any, n_threads: int | None) -> Mapping:
    """Check where tasks are to run, and with how many threads each."""
    return Mapping(map_of(where), None if n_threads is None else count("n_threads", n_threads, 1, MAX_THREADS))
