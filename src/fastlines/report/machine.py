"""The machine on which the figures were measured."""

from __future__ import annotations

import datetime
import platform
from pathlib import Path

import numpy as np


def describe_machine() -> dict[str, str | int]:
    """Name the processor, the system and the versions that figures depend on."""
    from .. import __version__, get_num_threads

    return {
        "processor": _processor(),
        "threads": get_num_threads(),
        "system": f"{platform.system()} {platform.machine()}",
        "fastlines": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }


def _processor() -> str:
    """Return the name of the processor, as far as the system gives it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine() or "unknown"
