"""The settings of a build: SPLITS, the cost model, presplit and limits.

The general builder has three parameters (thesis §4.3): the costs of a step and of a test, the candidate splits, and the
number of levels that the search looks ahead.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

import numpy as np

from ..arrays import LEAST, check_fields, choice, count, instance, number, sequence
from ..errors import InputError
from .splits import BoxRule, PlaneGrid, SplitSet

#: The most bytes that a build takes for a primitive, with room to spare; for a reference see `Limits.bytes_a_ref`.
_BYTES_A_PRIM = 160

#: The most references that the 32-bit indices of a tree can address.
REF_LIMIT = 2**32 - 16

#: The expected form of a cost model, for error messages.
COST = "fl.Cost(c_trav=…, c_prim=…)"


@dataclass(frozen=True)
class Cost:
    """The cost model: the costs of a step to a node and of a test of a primitive. Only their ratio matters (Theorem 2).

    Parameters
    ----------
    c_trav, c_prim : float
        From 1e-100 to 1e100, so that no cost overflows.
    """

    c_trav: float = 2.0
    c_prim: float = 1.0

    def __post_init__(self) -> None:
        what = "a cost: a positive finite number, from 1e-100 to 1e100"
        check_fields(self, ("c_trav", "c_prim"), number, what, 1e-100, 1e100)


@dataclass(frozen=True)
class Presplit:
    """Lines are cut before the build, in the middle of the longest side of their boxes, the largest box first.

    That is early split clipping (Ernst and Greiner 2007). With neither bound, trees with 1, 2, 4, … references a line
    are built as long as the next is cheaper by one part in a hundred. The tree's settings have the number of the best.

    Parameters
    ----------
    area : float, optional
        The largest area of a piece's box, as a fraction of the scene's surface area, above 0 to 1: the paper's bound.
        `Limits.max_refs` still holds.
    refs : float, optional
        The mean number of references for each line, at least 1.
    """

    area: float | None = None
    refs: float | None = None

    def __post_init__(self) -> None:
        if self.area is not None and self.refs is not None:
            raise InputError(f"area={self.area!r} and refs={self.refs!r} are two bounds; give one of them, or none")
        check_fields(self, ("area",), number, "a fraction of the scene's surface area, above 0 to 1", LEAST, 1.0)
        check_fields(self, ("refs",), number, f"references for each line, 1 to {REF_LIMIT}", 1.0, REF_LIMIT)


@dataclass(frozen=True)
class Limits:
    """Where a build ends, whatever the costs say. `Tree.limits_hit` counts the nodes at which each took effect.

    Parameters
    ----------
    max_depth : int
        Level of the deepest node; the root's level is 0.
    max_leaf_refs : int, optional
        The most references of a leaf. Larger nodes are split even where that costs more, but never with all references
        on both sides. Tight boxes only, because a KD tree cannot always separate its references.
    max_refs : int, optional
        The most references of a tree, at least the number of primitives; an empty leaf counts as one. The default is
        1,000 for each primitive and 10,000 more: among lines that coincide, some split always looks worth its cost.
    max_bytes : int, optional
        The build of "best" takes at most this memory beside its input. That lowers `max_refs`: a primitive counts as
        160 bytes. A reference counts as 80 where leaves are large, as those of "best" for queries, else as 160, and as
        300 with cut boxes. Presplit, reinsertion and object sweeps over large nodes take more than that. So do trees of
        least cost where long lines cross, up to 1.8 times as much: a node's list of references is kept until the search
        has split the node.
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

        A reference is 12 bytes, a node 36. For each reference, trees have a fifth of a node where leaves are large,
        less than one where leaves are small, and nearly two with cut boxes.
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
        """Return these limits, with the fields that are at their defaults taken from `base`."""
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(base, **{name: value for name, value in given.items() if value != getattr(Limits, name)})

    def __post_init__(self) -> None:
        check_fields(self, ("max_depth",), count, 0, 256)
        check_fields(self, ("leaf_refs", "max_refs", "max_bytes"), count, 0)
        check_fields(self, ("max_leaf_refs",), count, 1)
        check_fields(self, ("leaf_size",), number, "a length that is not negative", 0.0)


@dataclass(frozen=True)
class Settings:
    """All settings of a build.

    Parameters
    ----------
    splits : SplitSet or sequence of SplitSet
        The candidate splits; of several sets, their union.
    boxes : {"tight", "cut"}
        The boxes of children: tight around their primitives, for a BVH, or cut out of the parent's, for a KD tree.
    lookahead : int or sequence of int
        The number of levels to search. Of several, each is tried where the one before finds a leaf.
    beam : int, optional
        Search more than one level deep only below this many candidates, the cheapest at depth 1.
    exhaustive : bool
        Search below all candidates, also where a bound proves that it cannot pay. The tree is the same.
    cost : Cost
        The cost model.
    limits : Limits
        Where to stop.
    bad_levels : int
        How many levels in a row may be split although that looks no better than a leaf. Where long lines cross, the
        first levels of a good tree look bad.
    bad_refs : int
        Nodes of at most this many references are leaves where the best split looks no better, whatever `bad_levels`
        is: such a split hardly ever pays.
    bad_refines : int
        How many levels of a path may be cut in the middle of the longest side although the search finds a leaf (PBRT's
        bad refines, thesis §2.4).
    prune : bool
        Remove, from the bottom up, splits of bad levels that did not pay.
    radius_hint : float
        The search measures boxes grown by this fraction of the scene's longest side, because a query tests boxes grown
        by its radius.
    min_spread : float
        Lines that run along each other, within this fraction of the scene's longest side (root mean square), are never
        cut so that 0.3 (KD trees: 0.5) of a node are on both sides. A BVH splits them whole, a KD tree lists them in a
        leaf. 0 cuts all of them. Other primitives are cut as if it were 0.
    lanes : int
        The number of references tested at once: 1, 2, 4, 8, 16, 32 or 64, and at most `max_leaf_refs`. The search
        counts references as the mean of their number and the lanes they take, which makes fewer and fuller leaves.
        `Tree.cost` uses the plain number.
    presplit : Presplit, optional
        Cut lines before the build. Tight boxes and lines only.
    reinsertion : int
        After the build, take subtrees out and put them in where they cost least, in at most this many rounds. Tight
        boxes and lines only.

    Raises
    ------
    InputError
        If a setting cannot be used, or two of them do not fit together.
    """

    splits: tuple[SplitSet, ...] = (PlaneGrid(16),)
    boxes: BoxRule = "tight"
    lookahead: tuple[int, ...] = (1,)
    cost: Cost = Cost()
    limits: Limits = field(default_factory=Limits)
    bad_levels: int = 0
    prune: bool = True
    radius_hint: float = 0.0
    min_spread: float = 0.0
    lanes: int = 1
    presplit: Presplit | None = None
    reinsertion: int = 0
    bad_refines: int = 0
    bad_refs: int = 0
    beam: int | None = None
    exhaustive: bool = False

    def __post_init__(self) -> None:
        several = "a whole number, 1, 2, …, or a list of them to try in turn"
        splits = "one or more of fl.PlaneGrid(16), fl.ObjectSweep(), …"
        check_fields(self, ("splits",), sequence, SplitSet, splits)
        check_fields(self, ("lookahead",), sequence, (int, np.integer), several)
        object.__setattr__(self, "lookahead", tuple(count("lookahead", depth, 0, 8) for depth in self.lookahead))
        check_fields(self, ("bad_refs",), count, 0)
        check_fields(self, ("bad_levels", "bad_refines"), count, 0, 16)
        if max(self.lookahead) < 2 and (self.beam is not None or self.exhaustive):
            raise InputError(f"beam and exhaustive are for a lookahead of 2 or more, this is {self.lookahead}")
        check_fields(self, ("beam",), count, 1)
        check_fields(self, ("prune", "exhaustive"), instance, bool, "True or False")
        what = "a fraction of the scene's longest side, 0 to 1"
        check_fields(self, ("radius_hint", "min_spread"), number, what, 0.0, 1.0)
        check_fields(self, ("lanes",), _lanes)
        check_fields(self, ("presplit",), instance, Presplit, "fl.Presplit(), fl.Presplit(refs=…) or None")
        check_fields(self, ("reinsertion",), count, 0, 1000)
        check_fields(self, ("boxes",), choice, ("tight", "cut"))
        check_fields(self, ("cost",), instance, Cost, COST)
        check_fields(self, ("limits",), instance, Limits, "fl.Limits(max_depth=…, …)")
        most = self.limits.max_leaf_refs
        if most is not None and self.lanes > most:
            raise InputError(
                f"lanes={self.lanes} cannot be filled by leaves of max_leaf_refs={most}; lower lanes, or raise "
                "max_leaf_refs"
            )
        if self.boxes == "cut":
            for split in self.splits:
                if split.tight_only:
                    raise InputError(
                        f"{split} offers object splits, which need tight boxes; a KD tree (boxes='cut') takes planes, "
                        "such as fl.PlaneGrid(16)"
                    )
            for name, given, why in (
                ("max_leaf_refs", most is not None, "cannot be promised by a KD tree"),
                ("presplit", self.presplit is not None, "is for tight boxes: a KD tree cuts all lines itself"),
                ("reinsertion", self.reinsertion > 0, "is for tight boxes: those of a KD tree cannot move"),
            ):
                if given:
                    raise InputError(f"{name} {why}; leave it out, or build a BVH (boxes='tight')")


def _lanes(name: str, lanes: object) -> int:
    expected = (1, 2, 4, 8, 16, 32, 64)
    if isinstance(lanes, bool) or not isinstance(lanes, int | np.integer) or lanes not in expected:
        raise InputError(f"{name}={lanes!r}; expected one of {', '.join(map(str, expected))}")
    return int(lanes)


def limit_notes(limits_hit: Mapping[str, int]) -> list[str]:
    """Describe the effect of each limit on a build.

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
        phrase, noun = phrases.get(limit, ("took effect at {}", "node"))
        notes.append(f"{limit} {phrase.format(f'{n:,} {noun}' if n == 1 else f'{n:,} {noun}s')}")
    return notes
