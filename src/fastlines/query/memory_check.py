"""An early check whether lists of hits will fit into memory, by a sample of the rays while the query runs.

Each time a long query reports progress, the hits of some more rays are counted. Let n rays have a mean of m hits and a
standard deviation of s. The query is refused if (m - 3 s / √n) / 2 hits for each remaining ray take more memory than
there is. The margins keep queries that fit from being refused. Three standard errors cover a sample with too many rays
of many hits. The factor 1/2 covers a sample of such rays alone, and changes in the meantime.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath

import numpy as np

from ..arrays import IntArray
from ..engines import is_given
from ..progress import ProgressCallback

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]

#: How many rays are counted at a time; in all, at most MOST of them and at most one in ONE_OF of the batch.
AT_ONCE, MOST, ONE_OF = 16, 256, 16

#: Smaller answers, in bytes, are not refused: if they fail, they fail soon, and they may reuse freed memory.
SMALL = 5e8

#: The fraction of a query after which it is not refused: from then on the memory for all of its hits is allocated.
LATEST = 0.25

#: The golden ratio: fractional parts of its multiples spread any number of rays over a batch, and match no pattern.
GOLDEN = (math.sqrt(5) - 1) / 2

ROOT = Path("/")


class MemoryCheck:
    """Refuses a query whose hits will not fit into memory.

    `count_hits` returns the numbers of hits of the rays in given rows, and no ray has more than `most_hits`. `why` is
    what an error says after "do not fit into memory": nothing, or what the sample shows. `nouns` names the rays, which
    may be points or boxes.
    """

    def __init__(
        self,
        n_rays: int,
        bytes_a_hit: int,
        count_hits: Callable[[IntArray], IntArray],
        most_hits: float = math.inf,
        nouns: str = "rays",
    ) -> None:
        self.why, self._nouns = "", nouns
        self._n_rays, self._bytes_a_hit, self._count_hits = n_rays, bytes_a_hit, count_hits
        self._n_most = min(MOST, n_rays // ONE_OF) if n_rays * most_hits * bytes_a_hit > SMALL else 0
        self._addresses = left_addresses() if self._n_most >= AT_ONCE else math.inf
        self._counts = np.zeros(0, np.int64)

    def watch(self, callback: ProgressCallback | None) -> ProgressCallback | None:
        """Return a callback for the core that calls `look`, then `callback`.

        A module that counts steps is to count those of this query alone, so it gets no sample.
        """
        if is_given():
            return callback

        def look_and_call(share: float) -> None:
            self.look(share)
            if callback is not None:
                callback(share)

        return look_and_call

    def look(self, share: float) -> None:
        """Count the hits of some more rays when this fraction is done; raise MemoryError if the hits will not fit."""
        n_counted = len(self._counts)
        if share > LATEST or n_counted + AT_ONCE > self._n_most:
            return
        rows = (np.arange(n_counted, n_counted + AT_ONCE) * GOLDEN % 1 * self._n_rays).astype(np.int64)
        try:
            self._counts = np.concatenate([self._counts, self._count_hits(rows)])
        except MemoryError:  # no memory for the sample; the query itself may still fit
            self._n_most = 0
            return
        mean = float(self._counts.mean())
        error = float(self._counts.std()) / math.sqrt(len(self._counts))
        needed = (mean - 3 * error) / 2 * (1 - share) * self._n_rays * self._bytes_a_hit
        if needed > SMALL and needed > (left := min(self._addresses, left_memory())):
            n_hits = mean * self._n_rays
            sampled = (
                f"by a sample of {len(self._counts)} {self._nouns} they are about {n_hits / 1e6:,.0f} million and take "
                f"{n_hits * self._bytes_a_hit / 1e9:,.1f} GB, {max(left, 0) / 1e9:,.1f} GB are left"
            )
            self.why = f": {sampled}"
            raise MemoryError(sampled)


def left_bytes() -> float:
    """Return how many bytes this process may still allocate; ∞ where the system does not say."""
    return min(left_addresses(), left_memory())


def left_addresses() -> float:
    """Return how many bytes of addresses this process may still take (``ulimit -v``); ∞ without a limit."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0] if hasattr(resource, "RLIMIT_AS") else -1
    pages = _text(ROOT / "proc/self/statm").split() if limit >= 0 else []
    return limit - int(pages[0]) * resource.getpagesize() if pages else math.inf


def left_memory(root: Path = ROOT) -> float:
    """Return how many bytes are free, swap included; ∞ where the system does not say.

    The machine and each control group have a limit; the least counts. Cached pages of files count as free.
    """
    machine = _text(root / "proc/meminfo")
    swap = 1024 * _number(machine, "SwapFree")
    limits = [*_group_limits(root)]
    if "MemAvailable" in machine:
        limits.append(1024 * _number(machine, "MemAvailable"))
    return min(limits) + swap if limits else math.inf


def _group_limits(root: Path) -> Iterator[int]:
    """Yield the free bytes of each control group that this process is in, of either version."""
    for controllers, path in re.findall(r"^\d+:(.*?):/(.*)$", _text(root / "proc/self/cgroup"), re.MULTILINE):
        if controllers == "":
            top, most, used, total = "", "memory.max", "memory.current", ""
        elif "memory" in controllers.split(","):
            top, most, used, total = "memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_"
        else:
            continue
        # A container may find its own group at the top, whatever the path says.
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
