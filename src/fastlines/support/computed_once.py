"""Properties that are computed once, also if several threads ask for them at the same time."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any, TypeVar, overload

_T = TypeVar("_T")

#: Guards the table of locks for an instant; never held while a property is computed.
_GUARD = threading.RLock()

#: The locks that are in use, and by how many threads, for each object and name.
_locks: dict[tuple[int, str], tuple[threading.RLock, int]] = {}


class computed_once(cached_property[_T]):  # noqa: N801  # a decorator, as cached_property is
    """A property of one object, which one thread computes while others wait; it is kept in the object's ``__dict__``.

    Other objects, and other properties of the same object, are computed at the same time. `cached_property` has one
    lock for all objects of a class up to Python 3.11, and none since.

    Examples
    --------
    >>> class Tree:
    ...     @computed_once
    ...     def layout(self):
    ...         print("built")
    ...         return 1
    >>> tree = Tree()
    >>> tree.layout + tree.layout
    built
    2
    """

    @overload
    def __get__(self, instance: None, owner: type[Any] | None = None) -> computed_once[_T]: ...

    @overload
    def __get__(self, instance: object, owner: type[Any] | None = None) -> _T: ...

    def __get__(self, instance: Any, owner: type[Any] | None = None) -> Any:
        """Compute what is not kept yet; what is kept is found without this call."""
        if instance is None:
            return self
        kept, name = instance.__dict__, self.attrname
        assert name is not None
        with held(instance, name):
            if name not in kept:
                kept[name] = self.func(instance)
            return kept[name]


@contextmanager
def held(instance: object, name: str) -> Iterator[None]:
    """Hold the lock for something of one object, so that other threads wait; the same thread may enter it again.

    The lock is made when it is needed, and no part of the object, which stays free to be copied and pickled.

    Examples
    --------
    >>> with held([], "copies"), held([], "copies"):
    ...     pass
    """
    key = id(instance), name
    with _GUARD:
        lock, n_threads = _locks.get(key, (threading.RLock(), 0))
        _locks[key] = lock, n_threads + 1
    try:
        with lock:
            yield
    finally:
        with _GUARD:
            lock, n_threads = _locks.pop(key, (lock, 1))
            if n_threads > 1:
                _locks[key] = lock, n_threads - 1


def _forget_locks() -> None:
    """Forget the locks that a fork has copied: the threads that hold them are not in the new process."""
    global _GUARD
    _GUARD = threading.RLock()
    _locks.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_locks)
