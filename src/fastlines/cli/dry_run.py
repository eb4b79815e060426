"""What a build will take, found without it: ``fastlines build --dry-run``.

The builder cuts lines at planes, so the number of references depends on how lines cross. It is estimated as Knuth
estimates the size of a tree (1975, "Estimating the efficiency of backtrack programs"): walk from the root to a small
node, halve at medians, and choose the side with s references with a probability of s / (l + r). The expected number of
references is then n · Π (l + r) / m over the nodes of the walk, of m references each, times that of the small node,
which is built. That build is timed, too.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..geometry.any_geometry import AnyGeometry
from ..settings.build_memory import build_bytes, expected_refs, layout_bytes, most_prims, tree_bytes
from ..settings.settings import Settings
from ..threads import get_num_threads
from ..tree import Tree

#: The most references of a small node, and the number of walks.
SMALL, N_WALKS = 1 << 15, 4

#: The references of a node that decide how it is halved.
SAMPLE = 1 << 13

#: References lie apart if halves by their centres cost at most this fraction of the node; then none is cut.
APART = 0.85


def forecast(geometry: AnyGeometry, settings: Settings, build: Callable[[Any], Tree] | None) -> dict[str, Any]:
    """Return what a build takes, ready for JSON; `build` builds samples with the same settings.

    The seconds are None without samples: with no `build`, or of primitives that are not lines.
    """
    kind, rows = geometry.build_data()
    n_prims, seconds = len(rows), None
    n_refs = expected_refs(n_prims, settings)
    if build is not None and kind == "segments" and n_prims:
        estimates = []
        random = np.random.default_rng(0)
        for _ in range(N_WALKS if n_prims > SMALL else 1):
            pieces, factor = walk(rows.reshape(-1, 2, 3), random)
            start = time.perf_counter()
            tree = build(pieces)
            elapsed = time.perf_counter() - start
            estimates.append(factor * n_prims * tree.n_refs / len(pieces))
            work = _work(tree.n_refs)
        n_refs = max(n_prims, min(round(sum(estimates) / len(estimates)), settings.limits.refs_for(n_prims)))
        seconds = elapsed * _work(n_refs) / work
    return {**memory_facts(n_prims, n_refs, settings), "seconds": seconds}


def _work(n_refs: int) -> float:
    return n_refs * math.log2(n_refs + 1)


def memory_facts(n_prims: int, n_refs: int, settings: Settings) -> dict[str, Any]:
    """Return the number of references, what tree and layout take, and the peaks while they are made."""
    layout, peak = layout_bytes(n_refs)
    return {
        "n_refs": n_refs,
        "tree_bytes": tree_bytes(n_refs, settings),
        "build_peak_bytes": build_bytes(n_prims, settings, n_refs, get_num_threads()),
        "layout_bytes": layout,
        "layout_peak_bytes": peak,
    }


def advice(n_prims: int, n_refs: int, settings: Settings) -> str:
    """Say how many segments a tile of a forest may have, by the memory for its build."""
    refs_a_prim = n_refs / max(1, n_prims)
    most = {memory: most_prims(memory * 10**9, settings, refs_a_prim, get_num_threads()) for memory in (1, 4, 16)}
    return ", ".join(f"{n:,} in {memory} GB" for memory, n in most.items())


def walk(pieces: FloatArray, random: np.random.Generator) -> tuple[FloatArray, float]:
    """Walk from the root to a small node; return its pieces (n, 2, 3), and the factor of the walk."""
    factor = 1.0
    while len(pieces) > SMALL:
        # Halve a sample, which says how the node is to be halved.
        some = pieces[:: -(-len(pieces) // SAMPLE)]
        axis = int(np.argmax(some.max(axis=(0, 1)) - some.min(axis=(0, 1))))
        centre = some[:, :, axis].sum(axis=1)
        twice = np.partition(centre, len(centre) // 2)[len(centre) // 2]
        left = centre < twice
        if not left.any():
            return pieces[:: -(-len(pieces) // SMALL)], factor
        cost = _area(some[left]) * left.sum() + _area(some[~left]) * (~left).sum()
        if cost <= APART * _area(some) * len(some):
            to_left = bool(random.random() < left.mean())
            ends = pieces[:, 0, axis] + pieces[:, 1, axis]
            pieces = pieces[ends < twice if to_left else ends >= twice]
            continue
        plane = np.float32(twice / 2)
        n_left, n_right = (some[:, :, axis].min(axis=1) < plane).sum(), (some[:, :, axis].max(axis=1) >= plane).sum()
        to_left = bool(random.random() < n_left / (n_left + n_right))
        factor *= (n_left + n_right) / len(some)
        ends = np.minimum(*pieces[:, :, axis].T) < plane if to_left else np.maximum(*pieces[:, :, axis].T) >= plane
        pieces = _clipped(pieces[ends], axis, plane, to_left)
    return pieces, float(factor)


def _area(pieces: FloatArray) -> float:
    x, y, z = (pieces.max(axis=(0, 1)) - pieces.min(axis=(0, 1))).tolist()
    return float(x * y + y * z + z * x)


def _clipped(pieces: FloatArray, axis: int, plane: np.float32, to_left: bool) -> FloatArray:
    """Cut off what lies beyond a plane; `pieces` is a copy, which is changed."""
    for end, other in ((0, 1), (1, 0)):
        beyond = pieces[:, end, axis] > plane if to_left else pieces[:, end, axis] < plane
        from_, to = pieces[beyond, other], pieces[beyond, end]
        s = (plane - from_[:, axis]) / (to[:, axis] - from_[:, axis])
        pieces[beyond, end] = from_ + s[:, None] * (to - from_)
        pieces[beyond, end, axis] = plane
    return pieces
