"""The settings of a build: SPLITS, the cost model, presplit and limits.

The general builder is configurable in three places (thesis §4.3): the costs of a step and of a test, the set of
candidate splits, and how many levels the search looks ahead.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .checks import LEAST, check_fields, choice, count, instance, number, sequence
from .errors import InputError
from .limits import REF_LIMIT, Limits
from .splits import BinnedPlanes, BoxRule, ObjectSweep, PlaneGrid, SplitSet

#: How a cost model is made, for error messages.
COST = "fl.Cost(c_trav=…, c_prim=…)"


@dataclass(frozen=True)
class Cost:
    """The cost model: what a step to a node and what a test of a primitive cost. Only their ratio matters (Theorem 2).

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
    are built as long as the next is cheaper by one part in a hundred; the tree's settings tell where that ended.

    Parameters
    ----------
    area : float, optional
        No piece's box has a larger area, as a fraction of the scene's surface area, above 0 to 1: the paper's bound.
        `Limits.max_refs` still holds.
    refs : float, optional
        So many references for each line on average, at least 1.
    """

    area: float | None = None
    refs: float | None = None

    def __post_init__(self) -> None:
        if self.area is not None and self.refs is not None:
            raise InputError(f"area={self.area!r} and refs={self.refs!r} are two bounds; give one of them, or none")
        check_fields(self, ("area",), number, "a share of the area of the scene's box, above 0 to 1", LEAST, 1.0)
        check_fields(self, ("refs",), number, f"references for each line, 1 to {REF_LIMIT}", 1.0, REF_LIMIT)


@dataclass(frozen=True)
class Settings:
    """All settings of a build.

    Parameters
    ----------
    splits : SplitSet or sequence of SplitSet
        The candidate splits; of several sets, their union.
    boxes : {"tight", "cut"}
        How a child's box is made: tight around its primitives makes a BVH, cut out of its parent's makes a KD tree.
    lookahead : int or sequence of int
        The number of levels to search. Of several, each is tried where the one before finds a leaf.
    beam : int, optional
        Search more than one level deep only below this many candidates, those that are cheapest at depth 1.
    exhaustive : bool
        Search below all candidates, also where a bound proves that it cannot pay. The tree is the same.
    cost : Cost
        The cost model.
    limits : Limits
        Where to stop.
    bad_levels : int
        How many levels in a row may be split though that looks no better than a leaf. Where long lines cross, the first
        levels of a good tree look bad.
    bad_refs : int
        Nodes of at most this many references are leaves where the best split looks no better, whatever `bad_levels`
        is: there it hardly ever pays in the end.
    bad_refines : int
        How many levels of a path may be cut in the middle of the longest side though the search says leaf (PBRT's bad
        refines, thesis §2.4).
    prune : bool
        Take back, from the bottom up, what bad levels did not pay for.
    radius_hint : float
        The search measures boxes grown by this fraction of the scene's longest side, as a query with a radius
        tests boxes that are grown by it.
    min_spread : float
        Lines that run along each other, within this fraction of the scene's longest side (root mean square), are never
        cut so that 0.3 (KD trees: 0.5) of a node are on both sides: a BVH splits them whole, a KD tree lists them in a
        leaf. 0 cuts all of them. Other primitives are cut as if it were 0.
    lanes : int
        The number of references tested at once: 1, 2, 4, 8, 16, 32 or 64, and at most `max_leaf_refs`. The search
        counts references as the mean of their number and the lanes they take, which makes fewer and fuller leaves.
        `Tree.cost` counts them as they are.
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
        what = "a share of the scene's longest side, 0 to 1"
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
                f"lanes={self.lanes} cannot be filled by leaves of max_leaf_refs={most}; give fewer, or allow larger "
                "leaves"
            )
        if self.boxes == "cut":
            octets = [split for split in self.splits if isinstance(split, BinnedPlanes)]
            wholes = [split for split in octets if split.uncut_refs or split.gap_refs]
            if wholes or any(isinstance(split, ObjectSweep) for split in self.splits):
                what = "an object sweep does not cut space, nor do uncut_refs and gap_refs of BinnedPlanes"
                raise InputError(f"{what}: a KD tree (boxes='cut') needs planes")
            if self.limits.max_leaf_refs is not None:
                raise InputError("max_leaf_refs cannot be promised by a KD tree (boxes='cut'); leave it out")
            if self.presplit is not None:
                raise InputError(
                    "presplit is for tight boxes: a KD tree (boxes='cut') cuts all lines itself; leave it out"
                )
            if self.reinsertion > 0:
                raise InputError(
                    "reinsertion is for tight boxes: those of a KD tree (boxes='cut') cannot move; leave it out"
                )


def _lanes(name: str, lanes: object) -> int:
    expected = (1, 2, 4, 8, 16, 32, 64)
    if isinstance(lanes, bool) or not isinstance(lanes, int | np.integer) or lanes not in expected:
        raise InputError(f"{name}={lanes!r}; expected one of {', '.join(map(str, expected))}")
    return int(lanes)
