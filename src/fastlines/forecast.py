"""Whether lists of hits will fit into memory, by a sample of the rays while the query runs.

Each time a long query reports progress, the hits of some more rays are counted. Let n of them have a mean of m hits and
a standard deviation of s. The query is refused if (m - 3 s / √n) / 2 hits for each remaining ray take more memory than
there is. So a query that fits is not refused. Three standard errors cover a sample with too many of the rays with many
hits. The half covers a sample of these alone, and changes in the meantime.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .arrays import IntArray
from .memory import left_addresses, left_memory
from .progress import ProgressCallback

#: The rays counted at a time, the most in all, and the fraction of the rays, one of ONE_OF, that is the most too.
AT_ONCE, MOST, ONE_OF = 16, 256, 16

#: Smaller answers, in bytes, are not refused: they fail soon if at all, and may reuse memory of earlier answers.
SMALL = 5e8

#: The fraction of a query after which it is not refused: from then on the memory for all of its hits is allocated.
LATEST = 0.25

#: The fractional parts of multiples of the golden ratio spread any number of rays over a batch, in step with no pattern
#: in it.
GOLDEN = (math.sqrt(5) - 1) / 2


class Forecast:
    """The number of hits that a query will list.

    Parameters
    ----------
    n_rays : int
    bytes_a_hit : int
    count_hits : callable
        Returns the numbers of hits of the rays in the given rows.

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
        """Return a callback for the core that calls `look`, then `callback`."""

        def look_and_call(share: float) -> None:
            self.look(share)
            if callback is not None:
                callback(share)

        return look_and_call

    def look(self, share: float) -> None:
        """Count the hits of some more rays when this fraction of the query is done.

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
