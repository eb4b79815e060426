"""Which backend answers queries: the CPU, or a GPU. The rest of this package is imported when a GPU is first used."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ..arrays import choice

if TYPE_CHECKING:
    from .device import Device

#: The backends, by the names that `set_backend` and `Tree.to` take.
BACKENDS = ("cpu", "cuda")

_chosen = "cpu"

#: The device that `use_device` has put in the place of the GPU.
_given: Device | None = None


def set_backend(name: str) -> None:
    """Answer all later queries on the CPU or on a GPU, for trees that `Tree.to` has not placed.

    Answers are the same, bit for bit.

    Parameters
    ----------
    name : {"cpu", "cuda"}

    Raises
    ------
    MissingExtraError
        If the extra "cuda" is not installed.
    FastlinesError
        If there is no GPU, or no driver.
    """
    global _chosen
    _chosen = check_backend(name)


def get_backend() -> str:
    """Return which backend answers queries: "cpu" or "cuda"."""
    return _chosen


def check_backend(name: str) -> str:
    """Check the name of a backend, and that it can be used here."""
    choice("backend", name, BACKENDS)
    if name == "cuda":
        device()
    return name


def device() -> Device:
    """Return the device that answers queries in the backend "cuda"."""
    if _given is not None:
        return _given
    from .cuda_device import gpu

    return gpu()


@contextmanager
def use_device(given: Device) -> Iterator[None]:
    """Put another device in the place of the GPU for a while; for tests."""
    global _given
    before, _given = _given, given
    try:
        yield
    finally:
        _given = before
