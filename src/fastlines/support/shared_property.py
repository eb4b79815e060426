"""Properties that are computed once, also if several threads ask for them at the same time."""

from __future__ import annotations

import threading
from functools import cached_property
from typing import Any, TypeVar

_T = TypeVar("_T")

_LOCK = threading.RLock()


class shared_property(cached_property[_T]):  # noqa: N801  # a decorator, as cached_property is
    """A cached property that one thread computes while others wait.

    Since Python 3.12, `cached_property` lets each of them compute it.

    Examples
    --------
    >>> class Tree:
    ...     @shared_property
    ...     def layout(self):
    ...         print("built")
    ...         return 1
    >>> tree = Tree()
    >>> tree.layout + tree.layout
    built
    2
    """

    def __get__(self, instance: Any, owner: type[Any] | None = None) -> Any:
        """Return what is cached, or compute it."""
        with _LOCK:
            return super().__get__(instance, owner)
