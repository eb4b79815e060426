"""How much memory is left: to this process, to the groups that it is in, and on the machine."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]

ROOT = Path("/")


def left_addresses() -> float:
    """Return how many bytes of addresses this process may still take (``ulimit -v``); ∞ without a limit."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0] if hasattr(resource, "RLIMIT_AS") else -1
    pages = _text(ROOT / "proc/self/statm").split() if limit >= 0 else []
    return limit - int(pages[0]) * resource.getpagesize() if pages else math.inf


def left_memory(root: Path = ROOT) -> float:
    """Return how many bytes are left, swap included; ∞ where the system does not say.

    That is the least of the machine's memory and of each control group's. Cached pages of files count as left.
    """
    machine = _text(root / "proc/meminfo")
    swap = 1024 * _number(machine, "SwapFree")
    limits = [*_group_limits(root)]
    if "MemAvailable" in machine:
        limits.append(1024 * _number(machine, "MemAvailable"))
    return min(limits) + swap if limits else math.inf


def _group_limits(root: Path) -> Iterator[int]:
    """Yield what each control group that this process is in leaves it, of either version."""
    for controllers, path in re.findall(r"^\d+:(.*?):/(.*)$", _text(root / "proc/self/cgroup"), re.MULTILINE):
        if controllers == "":
            top, most, used, total = "", "memory.max", "memory.current", ""
        elif "memory" in controllers.split(","):
            top, most, used, total = "memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_"
        else:
            continue
        # A container may see its own group at the top, whatever the path says.
        group = PurePosixPath(path)
        for part in (group, *group.parents):
            folder = root / "sys/fs/cgroup" / top / part
            limit, in_use = _text(folder / most).strip(), _text(folder / used).strip()
            if limit.isdigit() and in_use.isdigit():  # "max" is none
                counts = _text(folder / "memory.stat")
                cached = sum(_number(counts, f"{total}{kind}_file") for kind in ("active", "inactive"))
                yield int(limit) - int(in_use) + cached


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _number(text: str, name: str) -> int:
    found = re.search(rf"^{name}:?\s+(\d+)", text, re.MULTILINE)
    return int(found[1]) if found else 0
