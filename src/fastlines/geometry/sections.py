"""Unbranched sections of trees of nodes."""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray


def find_sections(parent: IntArray, child: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Order segments, each from a node's parent to the node, by unbranched sections.

    Parameters
    ----------
    parent : (n,) int64
        The parent of each node; a root is its own.
    child : (k,) int64
        The node at the last end of each segment. Rising.

    Returns
    -------
    first : (k,) int64
        The node at the first end of each segment.
    sections : (k,) int64
        The section of each segment, in the new order: rising from 0.
    order : (k,) int64
        The segments in the new order: by section, and from its first to its last. A cycle without branches is a
        section that begins at its first segment.
    """
    n, n_segments = len(parent), len(child)
    first = parent[child]
    segment_of = np.full(n, -1)
    segment_of[child] = np.arange(n_segments)
    n_children = np.bincount(first[first != child], minlength=n)

    # A segment goes on from the one that ends at its first end, unless a branch or a root is there.
    here = np.arange(n_segments)
    before = segment_of[first]
    goes_on = (first != child) & (before >= 0) & (n_children[first] == 1)
    before = np.where(goes_on, before, here)

    # Double the steps back until all segments know the first of their section, and how far it is.
    start, n_steps = before, goes_on.astype(np.int64)
    for _ in range(max(n_segments, 1).bit_length()):
        n_steps = n_steps + n_steps[start]
        start = start[start]

    # What has not arrived at a first segment is a cycle.
    lost = np.flatnonzero(goes_on[start])
    after = np.zeros(n_segments, np.int64)
    after[before[lost]] = lost
    is_done = np.zeros(n_segments, np.bool_)
    for segment in lost.tolist():
        if is_done[segment]:
            continue
        at, step = segment, 0
        while not is_done[at]:
            is_done[at] = True
            start[at], n_steps[at] = segment, step
            at, step = int(after[at]), step + 1

    # Number the sections by their first segments.
    order = np.lexsort((n_steps, start))
    sections = np.unique(start[order], return_inverse=True)[1].reshape(-1)
    return first, sections, order


def count_rootless(parent: IntArray) -> int:
    """Return how many nodes descend from no root, but from a cycle; a root is its own parent."""
    ancestor = parent
    for _ in range(max(len(parent), 1).bit_length()):
        ancestor = ancestor[ancestor]
    return int(np.count_nonzero(parent[ancestor] != ancestor))
