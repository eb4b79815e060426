"""Lines: segments with their strands, radii and attributes, as plain arrays."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..arrays import (
    INVALID,
    AnyArray,
    FloatArray,
    IntArray,
    box_of,
    choice,
    kind_of,
    own_float32,
    refuse_masked,
    refuse_rows,
    unusable,
)
from ..errors import InputError
from ..support.computed_once import computed_once
from ..support.immutable import frozen, own
from ..support.vectors import dot, unit
from .any_geometry import AnyGeometry, Section
from .hit_places import Float64Array
from .line_input import Converted, check_columns, convert_segments, join_points, join_strands, valid_segments
from .offsets import checked_metadata, reduced
from .smooth_tangents import smooth_tangents
from .strand_points import StrandPoints
from .summary import summary_of

#: What the axes are called.
AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False, repr=False)
class Lines(StrandPoints):
    """Immutable line segments, with strands, radii and other attributes; writeable arrays are copied.

    The constructor takes arrays of exactly these types; `from_segments`, `from_strands` and `from_points` convert
    others. An attribute that is an array of Python objects is not copied, only marked read-only.

    Attributes
    ----------
    segments : (n, 2, 3) float32
        Both ends of each segment, in the units of the file that they came from.
    strands : (n,) int64
        The strand (hair, streamline, polyline) that each segment is part of; -1, the default, where there is none.
    radius : None, (n,) or (n, 2) float32
        Half the thickness, per segment or per end of a segment. Queries test capsules or round cones of this radius;
        ``fl.build(lines, own_radius=False)`` leaves it out.
    attributes : mapping of str to array
        Any other arrays, one row per segment.
    end_attributes : mapping of str to array
        What is known at both ends of each segment, (n, 2, …), as `from_points` makes it of values per point.
        `attributes` has the value of the first end, by the same name.
    skipped : (k,) int64
        Rows of the input that were left out because of ``invalid="skip"``. Then `rows` differs from the positions in
        `segments`.
    up : {"x", "y", "z"}, optional
        The axis that points upwards, where the format of their file says so. Pictures are drawn with it.
    unit : str, optional
        The unit of the coordinates, such as ``"mm"``, where the format of their file says so.
    metadata : mapping of str to value
        What is known of the lines as a whole: texts, numbers, lists and mappings of these, as JSON holds them. It is
        read-only, and lists and arrays become tuples. ``offset`` is what was subtracted from x, y and z (`offset`).
    """

    segments: FloatArray
    strands: IntArray = None  # type: ignore[assignment]  # becomes an array of -1
    radius: FloatArray | None = None
    attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    skipped: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    up: str | None = None
    end_attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    unit: str | None = None
    metadata: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        good = isinstance(self.segments, np.ndarray) and self.segments.flags.c_contiguous
        if not good or self.segments.dtype != np.float32 or self.segments.shape[1:] != (2, 3):
            raise InputError(
                f"Lines take a contiguous float32 array of shape (n, 2, 3), not {kind_of(self.segments)}; "
                "Lines.from_segments converts other arrays and lists"
            )
        if self.strands is None:
            object.__setattr__(self, "strands", np.full(len(self.segments), -1, np.int64))
        self._check_columns()
        if self.up is not None:
            choice("up", self.up, AXES)
        check_unit(self.unit)
        object.__setattr__(self, "metadata", checked_metadata(self.metadata))
        for name in ("segments", "strands", "radius", "skipped", "end_attributes", "attributes"):
            value = getattr(self, name)
            if name == "attributes":
                value = {**value, **{end: values[:, 0] for end, values in self.end_attributes.items()}}
            refuse_masked(value, name)
            object.__setattr__(self, name, frozen(value))
        refuse_rows(unusable(self.segments), "segments", "; Lines.from_segments(…, invalid='skip') leaves them out")

    @classmethod
    def restored(cls, **given: Any) -> Any:
        """See `Immutable`."""
        none: dict[str, Any] = dict.fromkeys(("radius", "up", "unit"))
        none |= {"skipped": np.empty(0, np.int64), "attributes": {}, "end_attributes": {}, "metadata": {}}
        parts, made = none | given, object.__new__(cls)
        first = {name: values[:, 0] for name, values in parts["end_attributes"].items()}
        parts |= {"attributes": parts["attributes"] | first, "metadata": checked_metadata(parts["metadata"])}
        made.__setstate__(parts)
        return made

    def _check_columns(self) -> None:
        """Refuse columns that do not fit the segments."""
        columns = self.strands, self.radius, self.attributes, self.skipped, self.end_attributes
        check_columns(len(self.segments), *columns)

    def __len__(self) -> int:
        return len(self.segments)

    @property
    def kind(self) -> str:
        """What the core calls the primitives that queries test: the `kKind` of a set of them in C++."""
        return "segments" if self.radius is None else "round cones"

    @computed_once
    def core_rows(self) -> FloatArray:
        """One row of numbers for each primitive, as queries read them: both ends, and the radius at each, if any.

        (n, 6) or (n, 8) float32.
        """
        if self.radius is None:
            return self.axes
        return self.cone_rows

    @computed_once
    def cone_rows(self) -> FloatArray:
        """Both ends of each segment and the radius at each, 0 if there is none: (n, 8) float32."""
        return np.asarray(own(np.concatenate([self.axes, self.end_radii], axis=1)))

    @property
    def derived(self) -> tuple[str, ...]:
        """See `Immutable`."""
        return () if self.radius is None else ("cone_rows", "max_radius")

    @property
    def axes(self) -> FloatArray:
        """Both ends of each segment, (n, 6) float32: what trees are built over, whatever the radius."""
        return self.segments.reshape(-1, 6)

    @property
    def end_radii(self) -> FloatArray:
        """The radius at both ends of each segment, (n, 2) float32; 0 if there is none."""
        radius = np.zeros(1, np.float32) if self.radius is None else self.radius
        return np.broadcast_to(radius if radius.ndim == 2 else radius[:, None], (len(self), 2))

    @computed_once
    def max_radius(self) -> float:
        """The largest radius; 0 if there is none."""
        return 0.0 if self.radius is None else float(self.radius.max(initial=0))

    def with_radius(self, radius: npt.ArrayLike) -> Lines:
        """Return the same lines with another radius.

        Parameters
        ----------
        radius : number, (n,) or (n, 2) array
            One for all, one for each segment, or one for each end.

        Examples
        --------
        >>> lines = Lines.from_segments([[[0, 0, 0], [1, 0, 0]]])
        >>> lines.with_radius(0.5).radius
        array([0.5], dtype=float32)
        """
        array = own_float32(radius, "radius")
        return replace(self, radius=own(np.full(len(self), array)) if array.ndim == 0 else array)

    def without_radius(self) -> Lines:
        """Return the same lines without their radius."""
        return Lines(**{of.name: getattr(self, of.name) for of in fields(Lines)} | {"radius": None})

    @property
    def bounds(self) -> FloatArray:
        """The box of all segments as (2, 3): lowest and highest corner; lowest > highest if there are none."""
        return box_of(self.segments.reshape(-1, 3))

    # --- What a kind of geometry answers ---

    place_words = "point", "segment"
    noun = "segments"
    heading = "lines"
    sections: ClassVar[Mapping[str, Section]] = {
        "segments": ("<f4", ((2, 3),), True),
        "strands": ("<i8", ((),), True),
        "radius": ("<f4", ((), (2,)), False),
        "skipped": ("<i8", ((),), False),
    }

    @property
    def straight(self) -> Lines:
        """The lines themselves."""
        return self

    @property
    def control_points(self) -> FloatArray:
        """Both ends of each segment."""
        return self.segments

    def axis_points(self, prim: IntArray, u: AnyArray) -> Float64Array:
        """See `AnyGeometry`."""
        ends = self.segments[prim].astype(np.float64)
        return np.asarray(ends[:, 0] + u[:, None] * (ends[:, 1] - ends[:, 0]))

    def smooth_tangents_at(self, prim: IntArray, u: FloatArray, tangents: FloatArray) -> FloatArray:
        """See `AnyGeometry`."""
        return smooth_tangents(self.segments, self.strands, prim, u, tangents)

    def lengths(self) -> Float64Array:
        """Return the length of each segment."""
        squares = np.zeros(len(self))
        for axis in range(3):
            edges = self.segments[:, 1, axis].astype(np.float64) - self.segments[:, 0, axis]
            squares += edges**2
        return np.asarray(np.sqrt(squares))

    def turns(self) -> FloatArray:
        """See `AnyGeometry`."""
        edges = self.segments[:, 1] - self.segments[:, 0]
        joined = (self.strands[1:] == self.strands[:-1]) & (self.segments[1:, 0] == self.segments[:-1, 1]).all(axis=1)
        return np.asarray(dot(unit(edges[:-1][joined]), unit(edges[1:][joined])), np.float32)

    def summary(self) -> dict[str, Any]:
        """See `AnyGeometry`."""
        lengths = self.lengths()
        median = float(np.median(lengths)) if len(self) else None
        arrays = [values for name, values in self.attributes.items() if name not in self.end_attributes]
        arrays += [self.segments, self.strands, *self.end_attributes.values()]
        arrays += [] if self.radius is None else [self.radius]
        return {
            **summary_of(self, {"n_segments": len(self)}, {"median_length": median}),
            "radius": None if self.radius_range is None else list(self.radius_range),
            "memory_bytes": sum(values.nbytes for values in arrays),
        }

    def drawn(self, rows: IntArray) -> Sequence[AnyGeometry]:
        """See `AnyGeometry`."""
        radius = None if self.radius is None else self.radius[rows]
        return (type(self)(self.segments[rows], radius=radius, up=self.up),)

    def outlines(self) -> tuple[Float64Array, Float64Array]:
        """See `AnyGeometry`."""
        return self.segments.astype(np.float64), self.end_radii.astype(np.float64)

    @property
    def is_plain(self) -> bool:
        """See `AnyGeometry`."""
        return type(self) is Lines

    def as_lines(self) -> Lines | None:
        """See `AnyGeometry`."""
        return self if self.is_plain else None

    def moved(self, lines: Any) -> Lines:
        """See `AnyGeometry`."""
        moved, kind = lines if isinstance(lines, Lines) else as_lines(reduced(lines, self.offset)[0]), type(self)
        if moved is lines and moved.offset != self.offset:
            raise InputError(f"lines with the offset {moved.offset} were given for a tree with {self.offset}; use that")
        if moved is lines and type(moved) is not kind:
            raise InputError(f"{moved!r} was given for a tree over {kind.__name__}; pass {kind.__name__}, or an array")
        if len(moved) != len(self):
            left = "; it skipped some rows: pass array[tree.geometry.rows]" if len(self.skipped) else ""
            raise InputError(f"{len(moved)} segments were given for a tree over {len(self)}; expected as many{left}")
        return moved if moved is lines else replace(self, segments=moved.segments)

    @classmethod
    def from_segments(
        cls, segments: npt.ArrayLike, *, offset: Any = None, invalid: str = "error", **more: Any
    ) -> Lines:
        """Check an array of segments and wrap it.

        Parameters
        ----------
        segments : (n, 2, 3) or (n, 6) array of numbers
            Both ends of each segment. Converted to float32.
        offset : "auto" or three numbers, optional
            Subtracted from x, y and z in float64 before they are rounded; see `fastlines.read`.
        invalid : {"error", "skip"}
            Refuse segments that hold NaN, Inf or a coordinate beyond 1e30, or leave them out and record their rows in
            ``skipped``. The ``prim`` of a hit then counts the segments that are left; its ``row``, those of the input.
        **more
            ``strands`` (-1 for none), ``radius``, ``attributes``, ``end_attributes``: a row a segment; or one radius.

        Raises
        ------
        InputError
            If the shape, the type or a value cannot be used.

        Examples
        --------
        >>> import fastlines as fl
        >>> lines = Lines.from_segments([[[0, 0, np.nan], [1, 1, 1]], [[0, 0, 0], [1, 1, 1]]], invalid="skip")
        >>> hits = fl.build(lines).first_hit([0.5, 0.5, -1], [0, 0, 1], 0.1)
        >>> print(hits.prim, hits.row)
        0 1
        """
        choice("invalid", invalid, INVALID)
        segments, facts = reduced(segments, offset)
        return cls._valid(convert_segments(segments, more), invalid, facts)

    @classmethod
    def _valid(cls, given: Converted, invalid: str, facts: Mapping[str, Any]) -> Lines:
        """Leave out, or refuse, invalid rows."""
        # Mostly all segments are valid, which the constructor checks.
        try:
            return cls(**given._asdict(), metadata=facts)
        except InputError:
            pass
        kept, skipped = valid_segments(given, invalid)
        return cls(**kept._asdict(), skipped=skipped, metadata=facts)

    @classmethod
    def from_points(
        cls,
        points: npt.ArrayLike,
        counts: npt.ArrayLike,
        *,
        radius: npt.ArrayLike | None = None,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        offset: Any = None,
        invalid: str = "error",
    ) -> Lines:
        """Join consecutive points to strands.

        Parameters
        ----------
        points : (m, 3) array
            The points of all strands, one strand after the other.
        counts : (k,) array of int
            How many points each strand has; they add up to m. A strand of one point becomes a segment of length
            zero, so that nothing is lost.
        radius : number or (m,) array, optional
            Half the thickness, everywhere or at each point; becomes one value per end of a segment.
        attributes : mapping of str to array of m rows, optional
            Per point; each segment has the values at both ends (`end_attributes`).
        offset, invalid
            See `from_segments`.
        """
        choice("invalid", invalid, INVALID)
        points, facts = reduced(points, offset)
        joined = join_points(points, counts, radius, attributes)
        return cls._valid(convert_segments(joined.pop("segments"), joined), invalid, facts)

    @classmethod
    def from_strands(
        cls,
        strands: Iterable[npt.ArrayLike],
        *,
        radius: npt.ArrayLike | Iterable[npt.ArrayLike] | None = None,
        attributes: Mapping[str, npt.ArrayLike | Iterable[npt.ArrayLike]] | None = None,
        offset: Any = None,
        invalid: str = "error",
    ) -> Lines:
        """Make lines of a sequence of polylines, each an (m, 3) array of points.

        Parameters
        ----------
        strands : sequence of arrays
        radius, attributes : optional
            As in `from_points`, for the points of all strands one after the other; or a sequence with an array for the
            points of each strand.
        offset, invalid
            See `from_segments`.

        Examples
        --------
        >>> strands = [[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[5, 5, 5], [6, 6, 6]]]
        >>> Lines.from_strands(strands, radius=[[1, 2, 3], [0.5, 0.5]]).radius.tolist()
        [[1.0, 2.0], [2.0, 3.0], [0.5, 0.5]]
        """
        return cls.from_points(**join_strands(strands, radius, attributes or {}, offset), invalid=invalid)


def check_unit(unit: object) -> None:
    """Refuse a unit that is not a text of one line."""
    if unit is not None and not (isinstance(unit, str) and unit and unit.isprintable()):
        raise InputError(f"unit {unit!r} is not the name of a unit, such as 'mm'")


def as_lines(lines: Lines | npt.ArrayLike, *, offset: Any = None, invalid: str = "error") -> Lines:
    """Return lines as they are; check and wrap an array of segments."""
    choice("invalid", invalid, INVALID)
    if isinstance(lines, str | os.PathLike):
        raise InputError(f"segments: {str(lines)!r} is the name of a file, not an array; fl.read reads files of lines")
    return lines if isinstance(lines, Lines) else Lines.from_segments(lines, offset=offset, invalid=invalid)
