"""Answers of queries, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .geometry import FloatArray, IntArray


@dataclass(frozen=True, eq=False, repr=False)
class FirstHits:
    """The nearest hit of each ray; every array has the shape of the question.

    Attributes
    ----------
    t : float32
        Where on the ray, in units of its direction; inf = miss.
    prim : int64
        Which segment, as a position in the input; -1 = miss. If segments were skipped, a position among those that are
        left: ``lines.rows[prim]`` is that in the input.
    u : float32
        Where on the segment, from 0 to 1.
    distance : float32
        Least distance of the ray from the segment; inf = miss.
    t_out : float32 or None
        With ``at="surface"``, where the ray leaves the capsule around the segment.
    skipped : (k,) int64
        Rays that could not be asked, with ``invalid="skip"``.
    """

    t: FloatArray
    prim: IntArray
    u: FloatArray
    distance: FloatArray
    t_out: FloatArray | None
    skipped: IntArray

    def __repr__(self) -> str:
        return f"<FirstHits: {self.prim.size:,} rays, {int(self.hit.sum()):,} hit>"

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """Which rays hit anything."""
        return self.prim >= 0


@dataclass(frozen=True, eq=False, repr=False)
class AllHits:
    """All hits of each ray, each once, sorted by (ray, t, prim).

    Those of ray i are at positions ``offsets[i]`` to ``offsets[i + 1]`` of the other arrays (compressed sparse rows).

    Attributes
    ----------
    offsets : (n_rays + 1,) int64
        Rays are counted in the order of the flattened question.
    t, prim, u, distance, t_out, skipped
        As in `FirstHits`, one entry a hit.
    """

    offsets: IntArray
    t: FloatArray
    prim: IntArray
    u: FloatArray
    distance: FloatArray
    t_out: FloatArray | None
    skipped: IntArray

    def __len__(self) -> int:
        return len(self.prim)

    def __repr__(self) -> str:
        return f"<AllHits: {len(self.offsets) - 1:,} rays, {len(self):,} hits>"

    @property
    def counts(self) -> IntArray:
        """How many hits each ray has, (n_rays,) int64."""
        return np.diff(self.offsets)

    @property
    def ray(self) -> IntArray:
        """The ray of each hit, (n_hits,) int64."""
        return np.repeat(np.arange(len(self.offsets) - 1), self.counts)

    def of(self, ray: int) -> slice:
        """Where the hits of a ray are: ``hits.t[hits.of(3)]``.

        Raises
        ------
        InputError
            There is no such ray; they count from 0.
        """
        n_rays = len(self.offsets) - 1
        if not 0 <= ray < n_rays:
            raise InputError(f"ray={ray}: there are {n_rays:,} rays, which count from 0")
        return slice(int(self.offsets[ray]), int(self.offsets[ray + 1]))
