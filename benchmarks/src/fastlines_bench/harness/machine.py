"""Where figures were measured."""

from __future__ import annotations

import os

from fastlines import simd

from ..package import describe_machine

__all__ = ["describe", "load"]


def load() -> float | None:
    """Return the mean number of processes that wanted to run in the last minute; None where the system has no such."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def describe(**more: object) -> dict[str, object]:
    """Name the processor, the system, the versions, the instruction set and the load, and what else is given."""
    return {**describe_machine(), "simd": simd(), "load": load(), **more}
