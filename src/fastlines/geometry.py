"""Lines: the geometry that everything else works on, as plain arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .errors import InputError

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int64]

#: Coordinates beyond this would overflow when squared in the arithmetic of the builders.
COORDINATE_LIMIT = 1e30


def list_rows(bad: npt.NDArray[np.bool_], shown: int = 5) -> str:
    """Name the rows of a mask for an error message: ``rows 3, 17 and 4 more``."""
    rows = np.flatnonzero(bad)
    text = ", ".join(str(row) for row in rows[:shown])
    more = f" and {len(rows) - shown} more" if len(rows) > shown else ""
    return f"{'row' if len(rows) == 1 else 'rows'} {text}{more}"


@dataclass(frozen=True, eq=False)
class Lines:
    """Line segments, with what is known about each.

    Attributes
    ----------
    segments : (n, 2, 3) float32
        Both ends of each segment, in the units of the file that they came from.
    strands : (n,) int64
        The strand (hair, streamline, polyline) that each segment is part of; -1 where there is none.
    radius : None, (n,) or (n, 2) float32
        Half the thickness, per segment or per end of a segment. Queries take their own radius and do not read it.
    attributes : mapping of str to array
        Anything else, one row per segment.
    skipped : (k,) int64
        Rows of the input that were left out because ``invalid="skip"`` was asked for.
    """

    segments: FloatArray
    strands: IntArray
    radius: FloatArray | None = None
    attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    skipped: IntArray = field(default_factory=lambda: np.empty(0, np.int64))

    def __len__(self) -> int:
        return len(self.segments)

    @property
    def bounds(self) -> FloatArray:
        """The box of all segments as (2, 3): lowest and highest corner; lowest > highest if there are none."""
        if len(self) == 0:
            return np.array([[np.inf] * 3, [-np.inf] * 3], np.float32)
        points = self.segments.reshape(-1, 3)
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def n_strands(self) -> int:
        """How many different strands the segments belong to."""
        return len(np.unique(self.strands[self.strands >= 0]))

    @classmethod
    def from_segments(cls, segments: npt.ArrayLike, *, invalid: str = "error", **more: Any) -> Lines:
        """Check an array of segments and wrap it.

        Parameters
        ----------
        segments : (n, 2, 3) or (n, 6) array of numbers
            Both ends of each segment. Converted to float32.
        invalid : {"error", "skip"}
            What to do with segments that hold NaN or Inf (or are too large for float32): raise, or leave them
            out and record their rows in ``skipped``.
        **more
            ``strands``, ``radius`` and ``attributes``, one row per segment.

        Raises
        ------
        InputError
            If the shape, the type or a value can not be used.
        """
        if invalid not in ("error", "skip"):
            raise InputError(f"invalid={invalid!r} is not a choice: use 'error' or 'skip'")
        array = to_float32(segments, "segments")
        if array.ndim == 2 and array.shape[1] == 6:
            array = array.reshape(-1, 2, 3)
        if array.size == 0 and array.shape in ((0,), (0, 2, 3)):
            array = array.reshape(0, 2, 3)
        if array.ndim != 3 or array.shape[1:] != (2, 3):
            raise InputError(
                f"segments have shape {array.shape}; expected (n, 2, 3): n segments, both ends, x y z"
            )
        n_given = len(array)
        strands = np.asarray(more.pop("strands", np.full(n_given, -1)), np.int64)
        radius = more.pop("radius", None)
        radius = None if radius is None else to_float32(radius, "radius")
        attributes = {name: np.asarray(values) for name, values in more.pop("attributes", {}).items()}
        if more:
            raise InputError(f"unknown argument {next(iter(more))!r}; known: strands, radius, attributes")
        for name, values in {"strands": strands, "radius": radius, **attributes}.items():
            if values is not None and (values.ndim == 0 or len(values) != n_given):
                raise InputError(f"{name} has shape {values.shape}; expected one row for each of {n_given} segments")

        # Leave out, or refuse, what no query could answer.
        bad = ~(np.abs(array) <= COORDINATE_LIMIT).all(axis=(1, 2))
        skipped = np.empty(0, np.int64)
        if bad.any():
            if invalid == "error":
                raise InputError(
                    f"{int(bad.sum())} of {n_given} segments hold NaN, Inf or a coordinate beyond "
                    f"{COORDINATE_LIMIT:g} ({list_rows(bad)}); mend them, or pass invalid='skip' to leave them out"
                )
            skipped = np.flatnonzero(bad)
            array, strands = array[~bad], strands[~bad]
            radius = None if radius is None else radius[~bad]
            attributes = {name: values[~bad] for name, values in attributes.items()}
        return cls(np.ascontiguousarray(array), strands, radius, attributes, skipped)

    @classmethod
    def from_points(
        cls,
        points: npt.ArrayLike,
        counts: npt.ArrayLike,
        *,
        radius: npt.ArrayLike | None = None,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
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
        radius : (m,) array, optional
            Half the thickness at each point; becomes one value per end of a segment.
        attributes : mapping of str to array of m rows, optional
            Per point; each segment takes the value of its first point.
        invalid : {"error", "skip"}
            See `from_segments`.
        """
        points = to_float32(points, "points").reshape(-1, 3)
        counts = np.asarray(counts, np.int64)
        if counts.sum() != len(points) or (counts < 0).any():
            raise InputError(f"strands count {counts.sum()} points in all, but {len(points)} points were given")

        # The first point of each segment: all but the last of its strand; a lone point joins itself.
        counts_used = counts[counts > 0]
        n_segments = np.maximum(counts_used - 1, 1)
        strands = np.repeat(np.flatnonzero(counts > 0), n_segments)
        strand_start = np.repeat(np.cumsum(counts_used) - counts_used, n_segments)
        segment_start = np.repeat(np.cumsum(n_segments) - n_segments, n_segments)
        first = strand_start + np.arange(len(strands)) - segment_start
        last = first + np.repeat(counts_used > 1, n_segments)
        at_ends = np.stack([first, last], axis=1)
        return cls.from_segments(
            points[at_ends],
            strands=strands,
            radius=None if radius is None else to_float32(radius, "radius")[at_ends],
            attributes={name: np.asarray(values)[first] for name, values in (attributes or {}).items()},
            invalid=invalid,
        )

    @classmethod
    def from_strands(cls, strands: Iterable[npt.ArrayLike], *, invalid: str = "error") -> Lines:
        """Make lines of a sequence of polylines, each an (m, 3) array of points."""
        parts: Sequence[FloatArray] = [to_float32(strand, "strand").reshape(-1, 3) for strand in strands]
        points = np.concatenate(parts) if parts else np.empty((0, 3), np.float32)
        return cls.from_points(points, [len(part) for part in parts], invalid=invalid)


def to_float32(values: npt.ArrayLike, name: str) -> FloatArray:
    """Convert to float32, or say which argument is not made of numbers."""
    try:
        with np.errstate(over="ignore"):
            array = np.asarray(values)
            if array.dtype.kind not in "fiub":
                raise TypeError(f"dtype {array.dtype}")
            return np.asarray(array, np.float32, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} can not be read as an array of numbers: {error}") from None


def as_lines(lines: Lines | npt.ArrayLike, *, invalid: str = "error") -> Lines:
    """Pass lines through; check and wrap an array of segments."""
    return lines if isinstance(lines, Lines) else Lines.from_segments(lines, invalid=invalid)
