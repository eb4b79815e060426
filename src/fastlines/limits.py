"""Where a build ends, whatever the costs say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from .checks import check_fields, count, number
from .splits import BoxRule

#: The most bytes that a build takes for a primitive, with room to spare; for a reference see `Limits.bytes_a_ref`.
_BYTES_A_PRIM = 160

#: The most references that the 32-bit indices of a tree can name.
REF_LIMIT = 2**32 - 16


@dataclass(frozen=True)
class Limits:
    """Where a build ends, whatever the costs say. `Tree.limits_hit` counts the nodes at which each took effect.

    Parameters
    ----------
    max_depth : int
        Level of the deepest node; the root's level is 0.
    max_leaf_refs : int, optional
        No leaf lists more: larger nodes are split though it looks dearer, but never so that all they list is on both
        sides. Tight boxes only, for a KD tree cannot always part its references.
    max_refs : int, optional
        No tree has more references; a leaf without any counts as one. It cannot be less than the number of primitives.
        By default 1,000 for each of them and 10,000 more: among lines that lie on each other there is always a split
        that looks worth it.
    max_bytes : int, optional
        The build of "best" takes at most this memory beside its input. That lowers `max_refs`: a primitive counts as
        160 bytes. A reference counts as 80 where leaves are large, as those of "best" for queries, else as 160, and as
        300 with cut boxes.
        Presplit, reinsertion and object sweeps over large nodes take more than that. So do trees of least cost whose
        nodes pass most of their references on to one side, as where long lines cross: the list of each is kept until
        it is known to be no leaf. They have taken up to 1.8 times as much.
    leaf_refs : int
        A node of at most this many references is not split.
    leaf_size : float
        A node whose longest side is at most this length is not split.
    """

    max_depth: int = 64
    max_leaf_refs: int | None = None
    max_refs: int | None = None
    leaf_refs: int = 1
    leaf_size: float = 0.0
    max_bytes: int | None = None

    def refs_for(self, n_prims: int, boxes: BoxRule = "tight") -> int:
        """Return the most references of a tree over `n_prims` primitives."""
        most = min(REF_LIMIT, 1000 * n_prims + 10_000 if self.max_refs is None else self.max_refs)
        if self.max_bytes is None:
            return most
        return max(0, min(most, (self.max_bytes - _BYTES_A_PRIM * n_prims) // self.bytes_a_ref(boxes)))

    def bytes_a_ref(self, boxes: BoxRule) -> int:
        """Return the most bytes that a build takes for a reference: four times the tree's, while arrays grow and move.

        A reference is 12 bytes, a node 36; trees have a fifth as many nodes as references where leaves are large, less
        than one where they are small, and nearly two with cut boxes.
        """
        if boxes == "cut":
            return 300
        return 160 if self.leaf_refs < 8 else 80

    def bytes_for(self, n_prims: int, boxes: BoxRule) -> int:
        """Return the estimated bytes of the smallest tree over `n_prims` primitives."""
        return n_prims * (_BYTES_A_PRIM + self.bytes_a_ref(boxes))

    def hold(self, n_refs: int) -> bool:
        """Return whether leaves of at most `max_leaf_refs` can hold `n_refs` references within `max_depth`."""
        return self.max_leaf_refs is None or n_refs <= self.max_leaf_refs * 2**self.max_depth

    def over(self, base: Limits) -> Limits:
        """Take from `base` what is at its default here."""
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(base, **{name: value for name, value in given.items() if value != getattr(Limits, name)})

    def __post_init__(self) -> None:
        check_fields(self, ("max_depth",), count, 0, 256)
        check_fields(self, ("leaf_refs", "max_refs", "max_bytes"), count, 0)
        check_fields(self, ("max_leaf_refs",), count, 1)
        check_fields(self, ("leaf_size",), number, "a length that is not negative", 0.0)


def limit_notes(limits_hit: Mapping[str, int]) -> list[str]:
    """Describe what each limit that took effect did to a build.

    Examples
    --------
    >>> limit_notes({"max_depth": 1, "max_refs": 81})
    ['max_depth kept 1 node from a split or move', 'max_refs refused a split at 81 nodes']
    >>> limit_notes({"max_leaf_refs": 518})
    ['max_leaf_refs forced 518 splits']
    """
    phrases = {
        "max_depth": ("kept {} from a split or move", "node"),
        "max_refs": ("refused a split at {}", "node"),
        "max_leaf_refs": ("forced {}", "split"),
    }
    notes = []
    for limit, n in limits_hit.items():
        phrase, noun = phrases.get(limit, ("was felt at {}", "node"))
        notes.append(f"{limit} {phrase.format(f'{n:,} {noun}' if n == 1 else f'{n:,} {noun}s')}")
    return notes
