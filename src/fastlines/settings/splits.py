"""Split sets: the candidate splits of a node, the SPLITS of the thesis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, TypeAlias

from ..arrays import LEAST, check_fields, count, number
from ..errors import InputError

BoxRule: TypeAlias = Literal["tight", "cut"]


@dataclass(frozen=True)
class SplitSet:
    """A set of candidate splits; one of the classes below.

    Parameters
    ----------
    max_refs : int, optional
        Use this set only at nodes of at most this many references.
    min_overlap : float
        Use this set only where the boxes of the best object split of the earlier sets overlap in a box of more than
        this fraction of the scene's surface area. SBVH restricts spatial splits so, with 1e-5 (Stich et al. 2009).
    """

    name: ClassVar[str] = ""
    max_refs: int | None = field(default=None, kw_only=True)
    min_overlap: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError("fl.SplitSet is what split sets have in common; use fl.PlaneGrid(16), fl.ObjectSweep(), …")
        check_fields(self, ("max_refs",), count, 1)
        check_fields(self, ("min_overlap",), number, "a fraction of the scene's surface area, 0 to 1", 0.0, 1.0)

    def for_any_primitive(self, boxes: BoxRule) -> tuple[SplitSet, ...]:
        """Return the sets of the same kinds of candidates for primitives that are not segments."""
        return (self,)

    @property
    def tight_only(self) -> bool:
        """Whether this set needs tight boxes, because it offers object splits."""
        return False


@dataclass(frozen=True)
class ObjectSweep(SplitSet):
    """All cuts of the references sorted by box centre, on each axis: classic SAH. Tight boxes only."""

    name = "object_sweep"
    tight_only = True


@dataclass(frozen=True)
class PlaneGrid(SplitSet):
    """The planes of a regular grid over the node's box.

    Parameters
    ----------
    n_planes : int
        How many planes on each axis, 1 to 4096.
    """

    name = "plane_grid"
    n_planes: int = 16

    def __post_init__(self) -> None:
        super().__post_init__()
        check_fields(self, ("n_planes",), count, 1, 4096)


@dataclass(frozen=True)
class BinnedPlanes(SplitSet):
    """The planes of a regular grid, by counts in bins; where it pays, also splits that cut no reference.

    They find the splits of `PlaneGrid` in less time: counts are exact, boxes are compared in float32. An uncut split
    puts each reference whole on the side of its centre (tight boxes only). `BinnedPlanes` are for segments; for other
    primitives `PlaneGrid` and, with `uncut_refs`, `ObjectSweep` replace them.

    Parameters
    ----------
    n_planes : int
        How many planes on each axis, 1 to 4096.
    uncut_refs : int
        Nodes of at most this many references are offered uncut splits as well as planes; 0 for none.
    uncut_only_refs : int
        Nodes of at most this many references are offered only uncut splits, if there are any.
    max_overlap : float
        Nodes of up to `uncut_refs` references are also offered only uncut splits where the boxes of the best one
        overlap little: by at most this fraction of the node's area; 0 for none.
    sample : int
        Nodes of twice as many references or more choose their plane by about this many of them; 0 uses all. The cost of
        an uncut split is always computed from all references.
    gap_refs : int
        Nodes of more than `uncut_refs` and up to this many references are split uncut across a gap (see `gap`).
    gap : float
        A node has a gap where an uncut split costs at most this fraction of a leaf; above 0 to 1.
    uncut_only_side : float
        Nodes whose longest side is less than this many times the radius of `radius_hint` are offered only uncut splits,
        if there are any. Where boxes hardly exceed a query's radius, smaller pieces save few tests. Tight boxes only.

    Notes
    -----
    A search of more than one level uses `sample` and `gap_refs` on its last level only.
    """

    name = "binned_planes"
    n_planes: int = 16
    uncut_refs: int = 0
    uncut_only_refs: int = 0
    max_overlap: float = 0.0
    sample: int = 0
    gap_refs: int = 0
    gap: float = 0.8
    uncut_only_side: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        check_fields(self, ("n_planes",), count, 1, 4096)
        check_fields(self, ("uncut_refs", "uncut_only_refs", "sample", "gap_refs"), count, 0)
        if self.uncut_only_refs > self.uncut_refs:
            raise InputError(
                f"uncut_only_refs={self.uncut_only_refs} is more than uncut_refs={self.uncut_refs}; raise uncut_refs"
            )
        check_fields(self, ("max_overlap",), number, "0 to 1", 0.0, 1.0)
        check_fields(self, ("gap",), number, "a fraction of a leaf's cost, above 0 to 1", LEAST, 1.0)
        check_fields(self, ("uncut_only_side",), number, "a multiple of the radius, 0 to 1e6", 0.0, 1e6)
        if 0 < self.gap_refs <= self.uncut_refs:
            raise InputError(
                f"gap_refs={self.gap_refs} is for nodes of more than uncut_refs={self.uncut_refs} "
                "references; make it larger, or leave it out"
            )

    @property
    def tight_only(self) -> bool:
        """Whether a setting allows object splits, which need tight boxes."""
        return self.uncut_refs > 0 or self.gap_refs > 0 or self.uncut_only_side > 0

    def for_any_primitive(self, boxes: BoxRule) -> tuple[SplitSet, ...]:
        """See `SplitSet`."""
        if boxes == "cut" or self.uncut_refs == 0:
            return (PlaneGrid(self.n_planes, max_refs=self.max_refs, min_overlap=self.min_overlap),)
        # Clipping takes long for other shapes, and does not make the tree cheaper.
        return (ObjectSweep(max_refs=self.max_refs, min_overlap=self.min_overlap),)


@dataclass(frozen=True)
class PlaneEvents(SplitSet):
    """Planes at the sides of the references' boxes, including those that cut off empty space: SAH for KD trees."""

    name = "plane_events"


@dataclass(frozen=True)
class Median(SplitSet):
    """One split at the median centre, on the axis with the least sum of both areas."""

    name = "median"


@dataclass(frozen=True)
class Midpoint(SplitSet):
    """One plane, in the middle of the longest side."""

    name = "midpoint"


def split_set_from(name: str, fields: Mapping[str, Any]) -> SplitSet:
    """Make a split set from its name and fields."""
    kinds = {kind.name: kind for kind in SplitSet.__subclasses__()}
    return kinds[name](**fields)
