"""The memory of a build, its tree and its layout, by a model of what they were measured to take.

``fastlines-bench study memory`` measures all three.
"""

from __future__ import annotations

from .settings import Settings

#: Bytes of a reference as builds move it: the reference and its box.
MOVED_REF = 36

#: Of a build, beside what grows with the input: the memory of tasks and of blocks that are kept for reuse.
AT_LEAST = 16 << 20

#: Bytes of the layout for each reference, and of its plans beside it while it is made.
LAYOUT_REF, LAYOUT_PLAN = 20, 14


def expected_refs(n_prims: int, settings: Settings) -> int:
    """Return how many references to expect of a tree over `n_prims` primitives, of which nothing else is known.

    Trees that cut nothing have one a primitive. Others had 1.0 to 1.5 over streamlines and hair; where long lines cross
    they have many more.
    """
    limits = settings.limits
    cut = 1.0 if all(split.tight_only for split in settings.splits) else 1.5 if settings.boxes == "tight" else 4.0
    presplit = settings.presplit
    first = n_prims if presplit is None or presplit.refs is None else max(n_prims, int(presplit.refs * n_prims))
    return max(n_prims, min(int(cut * first), limits.refs_for(n_prims, settings.boxes)))


def tree_bytes(n_refs: int, settings: Settings) -> int:
    """Return the bytes of a tree: 12 a reference and 36 a node."""
    if settings.boxes == "cut":
        return 84 * n_refs
    return (18 if settings.limits.leaf_refs >= 8 else 48) * n_refs


def build_bytes(n_prims: int, settings: Settings, n_refs: int | None = None) -> int:
    """Return the expected peak of a build's memory above its input, the tree included.

    The references of the root and those of its right child are there before the first node is. In the end there is the
    tree, beside some of the references.

    Parameters
    ----------
    n_prims : int
        The number of primitives.
    settings : Settings
        Those of the build, such as `best_settings(n_prims=n_prims)`.
    n_refs : int, optional
        The number of references; by default those of `expected_refs`.

    Examples
    --------
    >>> from fastlines.settings.methods import best_settings
    >>> n_prims = 1_000_000
    >>> build_bytes(n_prims, best_settings(n_prims=n_prims)) // n_prims
    88
    """
    n_refs = expected_refs(n_prims, settings) if n_refs is None else n_refs
    at_first = 3 * MOVED_REF * n_prims // 2
    return AT_LEAST + at_first + tree_bytes(n_refs, settings)


def layout_bytes(n_refs: int) -> tuple[int, int]:
    """Return the bytes of the layout of a tree of best leaves, and the peak while it is made."""
    return LAYOUT_REF * n_refs, (LAYOUT_REF + LAYOUT_PLAN) * n_refs
