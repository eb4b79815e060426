"""The machine on which figures are measured."""

from __future__ import annotations

import os

from fastlines import simd

from .internals import describe_machine

__all__ = ["describe", "load"]


def load() -> float | None:
    """Return the load average of the last minute; None if the system has none."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def describe(**more: object) -> dict[str, object]:
    """Return the processor, the system, the versions, the instruction set, the load, and all of `more`, by name."""
    return {**describe_machine(), "simd": simd(), "load": load(), **more}
