"""Strands that are stored one after the other, each as its number of points and then the points."""

from __future__ import annotations

from array import array

import numpy as np

from ...arrays import FloatArray, IntArray
from ..source import BAD_COPY, Source


def counted_points(source: Source, n_strands: int, *, negative: bool = False) -> tuple[FloatArray, IntArray]:
    """Read the rest of a file: strands, each an int32 count and as many triples of float32, little-endian.

    Parameters
    ----------
    n_strands : int
        As the header promises; the file must hold just as many.
    negative : bool
        Whether a count may be negative, and then marks its strand.

    Returns
    -------
    points : (m, 3) float32
    counts : (n_strands,) int64
        As they stand in the file.
    """
    start = source.position
    words = source.array("words", "<i4", ((len(source.data) - start) // 4,))
    counts = array("i")
    at = 0
    while len(counts) < n_strands:
        if at >= len(words):
            raise source.error(f"announces {n_strands} strands, but ends after {len(counts)}; {BAD_COPY}")
        count = int(words[at])
        end = at + 1 + 3 * abs(count)
        if end > len(words) or (count < 0 and not negative):
            raise source.error(f"strand {len(counts)} announces {count} points, which are not there; {BAD_COPY}")
        counts.append(count)
        at = end
    source.position = start + 4 * at
    source.finish()

    # Separate the counts from the points.
    n_points = np.array(counts, np.int64)
    sizes = 1 + 3 * np.abs(n_points)
    is_point = np.ones(at, np.bool_)
    is_point[np.cumsum(sizes) - sizes] = False
    return words.view("<f4")[:at][is_point].reshape(-1, 3).astype(np.float32, copy=False), n_points
