"""Split sets: which candidates there are for a node, the SPLITS of the thesis."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal, TypeAlias

from .checks import count, number
from .errors import InputError

BoxRule: TypeAlias = Literal["tight", "cut"]


@dataclass(frozen=True)
class SplitSet:
    """A set of candidate splits; one of the classes below.

    Parameters
    ----------
    max_refs : int, optional
        Ask this set only about nodes of at most so many references.
    min_overlap : float
        Ask this set only where the boxes of the best object split of the sets before it overlap, in a box with more
        area than this share of the scene's: SBVH's restriction of spatial splits, with 1e-5 (Stich et al. 2009).
    """

    name: ClassVar[str] = ""
    max_refs: int | None = field(default=None, kw_only=True)
    min_overlap: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        if not self.name:
            raise InputError("fl.SplitSet is what split sets have in common; use fl.PlaneGrid(16), fl.ObjectSweep(), …")
        if self.max_refs is not None:
            object.__setattr__(self, "max_refs", count("max_refs", self.max_refs, 1))
        what = "a share of the area of the scene's box, 0 to 1"
        overlap = 0.0 if self.min_overlap == 0 else number("min_overlap", self.min_overlap, what, 0.0, 1.0)
        object.__setattr__(self, "min_overlap", overlap)

    @property
    def octet_args(self) -> tuple[int, int, float, int, int, float]:
        """What the core is told of octets of planes beside their number."""
        return 0, 0, 0.0, 0, 0, 0.0


@dataclass(frozen=True)
class ObjectSweep(SplitSet):
    """All cuts of the references sorted by box centre, on each axis: classic SAH. Tight boxes only."""

    name = "object_sweep"


@dataclass(frozen=True)
class PlaneGrid(SplitSet):
    """The planes of a regular grid over the node's box.

    Parameters
    ----------
    n_planes : int
        How many on each axis, 1 to 4096.
    """

    name = "plane_grid"
    n_planes: int = 16

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "n_planes", count("n_planes", self.n_planes, 1, 4096))


@dataclass(frozen=True)
class PlaneOctets(SplitSet):
    """The planes of a regular grid, counted eight at a time; also splits into whole primitives where that does well.

    What `PlaneGrid` finds, in less time: counts are exact, but the boxes by which candidates are compared are
    computed in float32. In nodes of up to `max_whole` references, tight boxes only, each plane also parts whole
    references by their centres. Large nodes may be judged by a `sample`. For segments; of other primitives a
    `PlaneGrid` and, for `max_whole`, an `ObjectSweep` are asked.

    Parameters
    ----------
    n_planes : int
        How many on each axis, 1 to 4096.
    max_whole : int
        The most references that are split whole.
    only_whole : int
        Up to so many they are split only so, where that divides them.
    max_overlap : float
        And so are more of them, up to `max_whole`, where the children of the best such split overlap in a box with no
        more than this share of the node's area; 0 for none.
    sample : int
        Of twice as many references and more, the plane is chosen by about so many; by all if it is 0, and in searches
        of more than one level, but for the last one. What a whole split costs is judged by all.
    max_apart : int
        Nodes of more than `max_whole` and up to so many references are split whole, and only so, where these lie apart:
        where it costs no more than `apart` allows. Not in searches of more than one level, but for the
        last one.
    apart : float
        A whole split is taken if it costs no more than this share of a leaf, above 0 to 1.
    """

    name = "plane_octets"
    n_planes: int = 16
    max_whole: int = 0
    only_whole: int = 0
    max_overlap: float = 0.0
    sample: int = 0
    max_apart: int = 0
    apart: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "n_planes", count("n_planes", self.n_planes, 1, 4096))
        for name in ("max_whole", "only_whole", "sample", "max_apart"):
            object.__setattr__(self, name, count(name, getattr(self, name), 0))
        if self.only_whole > self.max_whole:
            raise InputError(
                f"only_whole={self.only_whole} is more than max_whole={self.max_whole}; allow more of both"
            )
        overlap = 0.0 if self.max_overlap == 0 else number("max_overlap", self.max_overlap, "0 to 1", 0.0, 1.0)
        object.__setattr__(self, "max_overlap", overlap)
        object.__setattr__(
            self, "apart", number("apart", self.apart, "a share of a leaf's cost, above 0 to 1", 0.0, 1.0)
        )
        if 0 < self.max_apart <= self.max_whole:
            raise InputError(
                f"max_apart={self.max_apart} is for nodes of more than max_whole={self.max_whole} references; "
                "make it larger, or leave it out"
            )

    @property
    def octet_args(self) -> tuple[int, int, float, int, int, float]:
        """See `SplitSet`."""
        return self.max_whole, self.only_whole, self.max_overlap, self.sample, self.max_apart, self.apart

    def for_any_primitive(self, boxes: BoxRule) -> tuple[SplitSet, ...]:
        """Return the exact split sets that show the same kinds of candidates."""
        grid = PlaneGrid(self.n_planes, max_refs=self.max_refs, min_overlap=self.min_overlap)
        if boxes == "cut" or self.max_whole == 0:
            return (grid,)
        return grid, ObjectSweep(
            max_refs=min(self.max_whole, self.max_refs or self.max_whole), min_overlap=self.min_overlap
        )


@dataclass(frozen=True)
class PlaneEvents(SplitSet):
    """Planes at the sides of the references' boxes, among them those that cut off empty space: SAH for KD trees."""

    name = "plane_events"


@dataclass(frozen=True)
class Median(SplitSet):
    """One split at the median centre, on the axis where both areas add up to least."""

    name = "median"


@dataclass(frozen=True)
class Middle(SplitSet):
    """One plane, in the middle of the longest side."""

    name = "middle"
