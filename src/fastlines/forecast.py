"""Whether lists of hits will fit into memory: told by a few of the rays while the others are under way.

Each time a long query looks in, the hits of some more rays are counted. With a mean of m and a standard deviation of s
for n of them, the query is refused if (m - 3 s / √n) / 2 hits for each ray that is left take more memory than there is.
So a query that fits is not refused: three standard errors cover a sample with too many of the rays that hit much; the
half covers one with no others, and what changes meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .arrays import IntArray
from .memory import left_addresses, left_memory
from .progress import ProgressCallback

#: Rays that are counted at a time, and in all: at most that many, and one of so many.
AT_ONCE, MOST, ONE_OF = 16, 256, 16

#: Bytes of an answer that is not refused: it is soon found out, and may take memory that earlier answers have left.
SMALL = 5e8

#: The share of a query beyond which it takes its chances: from then on the memory for all of its hits is taken.
LATEST = 0.25

#: Multiples of the golden ratio, but for their whole parts, spread any number of rays over a batch, in step with no
#: pattern that is in it.
GOLDEN = (math.sqrt(5) - 1) / 2


class Forecast:
    """How many hits a query will list.

    Parameters
    ----------
    n_rays : int
    bytes_a_hit : int
    count_hits : callable
        Returns the numbers of hits to list of the rays in the given rows.

    Attributes
    ----------
    refusal : str
        Why the query was refused; empty as long as it was not.
    """

    def __init__(self, n_rays: int, bytes_a_hit: int, count_hits: Callable[[IntArray], IntArray]) -> None:
        self.refusal = ""
        self._n_rays, self._bytes_a_hit, self._count_hits = n_rays, bytes_a_hit, count_hits
        self._n_most = min(MOST, n_rays // ONE_OF)
        self._addresses = left_addresses() if self._n_most >= AT_ONCE else math.inf
        self._counts = np.zeros(0, np.int64)

    def watch(self, callback: ProgressCallback | None) -> ProgressCallback:
        """Return what the core calls from time to time: it looks, then calls `callback`."""

        def look_and_call(share: float) -> None:
            self.look(share)
            if callback is not None:
                callback(share)

        return look_and_call

    def look(self, share: float) -> None:
        """Count the hits of some more rays while this share of the query is done.

        Raises
        ------
        MemoryError
            If the hits will not fit.
        """
        n_counted = len(self._counts)
        if share > LATEST or n_counted + AT_ONCE > self._n_most:
            return
        rows = (np.arange(n_counted, n_counted + AT_ONCE) * GOLDEN % 1 * self._n_rays).astype(np.int64)
        try:
            self._counts = np.concatenate([self._counts, self._count_hits(rows)])
        except MemoryError:  # too little for a sample: the query may fit all the same
            self._n_most = 0
            return
        mean = float(self._counts.mean())
        error = float(self._counts.std()) / math.sqrt(len(self._counts))
        needed = (mean - 3 * error) / 2 * (1 - share) * self._n_rays * self._bytes_a_hit
        if needed > SMALL and needed > (left := min(self._addresses, left_memory())):
            n_hits = mean * self._n_rays
            self.refusal = (
                f"by a sample of {len(self._counts)} rays they are about {n_hits / 1e6:,.0f} million and take "
                f"{n_hits * self._bytes_a_hit / 1e9:,.1f} GB, {max(left, 0) / 1e9:,.1f} GB are left"
            )
            raise MemoryError(self.refusal)
