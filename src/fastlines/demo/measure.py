"""Timing a tree, and keeping its answers in a form that can be compared with those of another."""

from __future__ import annotations

import statistics
import time
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray
from ..camera import Camera
from ..hits import AllHits
from ..tree import Tree

Kind = Literal["first", "all"]
#: Rays are left out by taking every 2nd, 4th, … row and column.
STRIDES = (1, 2, 4, 8, 16, 32)
#: About so many hits are asked for at a time.
MAX_HITS = 1 << 22


@dataclass(frozen=True, eq=False)
class Answers:
    """The answers to the rays of every stride-th row and column, as one row of numbers a ray."""

    stride: int
    values: npt.NDArray[np.uint64]

    def count_differences(self, other: Answers) -> tuple[int, int]:
        """Of the rays that both were asked: how many have another answer, and how many there are."""
        stride = max(self.stride, other.stride)
        mine, theirs = (
            answers.values[:: stride // answers.stride, :: stride // answers.stride] for answers in (self, other)
        )
        differ = (mine != theirs).any(axis=2)
        return int(differ.sum()), differ.size


@dataclass(frozen=True)
class Timing:
    """How long a query took.

    Attributes
    ----------
    n_rays : int
        How many rays the query has.
    n_measured : int
        How many of them were asked.
    seconds : float
        What was measured, for these.
    n_hits : int
        What they hit.
    """

    n_rays: int
    n_measured: int
    seconds: float
    n_hits: int

    @property
    def ms(self) -> float:
        """Milliseconds for all rays; scaled up if not all were asked."""
        return 1e3 * self.seconds * self.n_rays / self.n_measured

    @property
    def mrays(self) -> float:
        """Millions of rays a second."""
        return self.n_measured / self.seconds / 1e6

    def to_json(self) -> dict[str, Any]:
        """Everything about it."""
        return {**asdict(self), "ms": self.ms}


@dataclass(frozen=True, eq=False)
class CameraRays:
    """The rays of a square picture, as a grid."""

    origin: FloatArray
    directions: FloatArray

    @classmethod
    def of(cls, camera: Camera, size: int) -> CameraRays:
        """Take those of a picture of size × size pixels."""
        origins, directions = camera.rays(size, size)
        return cls(origins[0], directions.reshape(size, size, 3))

    def __len__(self) -> int:
        return self.directions.size // 3


def measure(tree: Tree, rays: CameraRays, kind: Kind, radius: float, budget: float) -> tuple[Timing, Answers]:
    """Ask the rays of a picture, or an even part of them if all would take longer than the budget.

    Parameters
    ----------
    tree : Tree
    rays : CameraRays
    kind : {"first", "all"}
    radius : float
    budget : float
        In seconds; the first, small part of the rays that is asked to find out may exceed it.
    """
    # From the coarsest grid, which first warms up, go finer while there is time: each has 4 times the rays.
    size = len(rays.directions)
    strides = [stride for stride in reversed(STRIDES) if size // stride >= 8] or [1]
    best = _run(tree, rays, kind, radius, strides[0], size)
    for stride in strides:
        n_known, n_hits = best.answers.values[..., 0].size, best.n_hits
        hits_per_row = max(4.0, n_hits / n_known) * size / stride
        max_rows = max(1, int(MAX_HITS / hits_per_row)) if kind == "all" else size
        best = _run(tree, rays, kind, radius, stride, max_rows)
        if 4 * best.seconds > budget:
            break

    # Repeat what is short.
    seconds = [best.seconds]
    while len(seconds) < 3 and sum(seconds) < budget / 3:
        seconds.append(_run(tree, rays, kind, radius, stride, max_rows).seconds)
    n_measured = best.answers.values[..., 0].size
    return Timing(len(rays), n_measured, statistics.median(seconds), best.n_hits), best.answers


@dataclass(frozen=True)
class _Run:
    seconds: float
    answers: Answers
    n_hits: int


def _run(tree: Tree, rays: CameraRays, kind: Kind, radius: float, stride: int, max_rows: int) -> _Run:
    """Ask once, so many rows at a time."""
    directions = np.ascontiguousarray(rays.directions[::stride, ::stride])
    seconds, n_hits = 0.0, 0
    parts = []
    for top in range(0, len(directions), max_rows):
        rows = directions[top : top + max_rows]
        hits: Any
        start = time.perf_counter()
        # The trees themselves are compared, so they are searched as they were built.
        ask = tree.first_hit if kind == "first" else tree.all_hits
        hits = ask(rays.origin, rows, radius, kernel="binary")
        seconds += time.perf_counter() - start
        if kind == "first":
            values = np.stack([hits.t.view(np.uint32), hits.prim], axis=-1).astype(np.uint64)
            n_hits += int(hits.hit.sum())
        else:
            values = digest(hits).reshape(*rows.shape[:2], 2)
            n_hits += len(hits)
        parts.append(values)
    return _Run(seconds, Answers(stride, np.concatenate(parts)), n_hits)


def digest(hits: AllHits) -> npt.NDArray[np.uint64]:
    """Reduce the hits of each ray to two numbers: how many, and a hash of their t, their prim and their order.

    Returns
    -------
    (n_rays, 2) uint64
    """
    counts = hits.counts.astype(np.uint64)
    order = np.arange(len(hits), dtype=np.uint64) - np.repeat(hits.offsets[:-1].astype(np.uint64), hits.counts)
    key = hits.prim.astype(np.uint64) << np.uint64(32) | hits.t.view(np.uint32)
    # The finaliser of SplitMix64, keyed by the place of the hit in its ray's list.
    key += (order + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    key = (key ^ (key >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    key = (key ^ (key >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    key ^= key >> np.uint64(31)
    total = np.concatenate([np.zeros(1, np.uint64), np.cumsum(key, dtype=np.uint64)])
    return np.stack([counts, total[hits.offsets[1:]] - total[hits.offsets[:-1]]], axis=-1)
