"""The memory of a build, its tree and its layout, by a model of what they were measured to take.

``fastlines-bench study memory`` measures all three.
"""

from __future__ import annotations

from .settings import Settings
from .splits import ObjectSweep

#: Bytes of a reference as builds move it: the reference and its box.
MOVED_REF = 36

#: Bytes of a primitive while nodes pass their memory on to their children: the references of the root, half as many for
#: its right child, and a share of the blocks that are just in between.
PASSED_ON = 60

#: Bytes of the boxes and the order of a sweep over all references of a node.
SWEEP = 40

#: The most bytes of a thread, for its tasks and for blocks that are kept for reuse, and its bytes for each primitive.
OF_THREAD, OF_THREAD_A_PRIM = 16 << 20, 160

#: What grows with the references that cuts add, in bytes of the tree.
ADDED = 1.13

#: Bytes of the layout for each reference, and of its plans beside it while it is made.
LAYOUT_REF, LAYOUT_PLAN = 20, 4


def expected_refs(n_prims: int, settings: Settings) -> int:
    """Return the expected number of references of a tree, if only the number of its primitives is known.

    Trees that cut nothing have one a primitive. Others had 1.0 to 1.5 over a million segments of streamlines and hair;
    where long lines cross they have many more.
    """
    limits = settings.limits
    cuts = not all(isinstance(split, ObjectSweep) for split in settings.splits)
    cut = 1.0 if not cuts else 1.5 if settings.boxes == "tight" else 4.0
    presplit = settings.presplit
    first = n_prims if presplit is None or presplit.refs is None else max(n_prims, int(presplit.refs * n_prims))
    return max(n_prims, min(int(cut * first), limits.refs_for(n_prims, settings.boxes)))


def tree_bytes(n_refs: int, settings: Settings) -> int:
    """Return the expected bytes of a tree: 12 a reference, and 36 a node."""
    if settings.boxes == "cut":
        return 84 * n_refs
    return round((17.5 if settings.limits.leaf_refs >= 8 else 48) * n_refs)


def build_bytes(n_prims: int, settings: Settings, n_refs: int | None = None, n_threads: int = 2) -> int:
    """Return the expected peak of a build's memory above its input, the tree included.

    Parameters
    ----------
    n_prims : int
        The number of primitives.
    settings : Settings
        Those of the build, such as `best_settings(n_prims=n_prims)`.
    n_refs : int, optional
        The number of references; by default those of `expected_refs`.
    n_threads : int
        The number of threads that build.

    Examples
    --------
    >>> from fastlines.settings.methods import best_settings
    >>> n_prims = 4_000_000
    >>> build_bytes(n_prims, best_settings(n_prims=n_prims), n_refs=n_prims) // n_prims
    68
    """
    n_refs = expected_refs(n_prims, settings) if n_refs is None else n_refs
    of_threads = n_threads * min(OF_THREAD, OF_THREAD_A_PRIM * n_prims)
    whole = tree_bytes(n_prims, settings)
    added = ADDED * max(0, tree_bytes(n_refs, settings) - whole)
    if settings.prune and settings.limits.max_leaf_refs is None:
        # Each node keeps its references until it is known whether it becomes a leaf.
        sweeps = any(isinstance(split, ObjectSweep) and split.max_refs is None for split in settings.splits)
        a_prim = 3 * MOVED_REF + (SWEEP if sweeps else 0)
        return of_threads + a_prim * n_prims + whole + round(2 * added)
    return of_threads + PASSED_ON * n_prims + round(added)


def most_prims(memory: int, settings: Settings, refs_a_prim: float = 1.5, n_threads: int = 2) -> int:
    """Return how many segments a build within `memory` bytes can have: input, build, and the layout beside the tree.

    Examples
    --------
    >>> from fastlines.settings.methods import best_settings
    >>> most_prims(10**9, best_settings(n_prims=10**6)) // 10**6
    9
    """
    many = 1 << 24
    n_refs = round(refs_a_prim * many)
    fixed = OF_THREAD * n_threads
    building = build_bytes(many, settings, n_refs, n_threads) - fixed
    querying = tree_bytes(n_refs, settings) + layout_bytes(n_refs)[1]
    return max(0, int((memory - fixed) / (INPUT + max(building, querying) / many)))


def layout_bytes(n_refs: int) -> tuple[int, int]:
    """Return the bytes of a layout, and their peak while it is made."""
    return LAYOUT_REF * n_refs, (LAYOUT_REF + LAYOUT_PLAN) * n_refs


#: Bytes of a segment and its strand.
INPUT = 32
