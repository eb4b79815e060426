"""Several containers of primitives for one tree, and what a tree can be over."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NoReturn

import numpy as np
import numpy.typing as npt

from ..arrays import INVALID, AnyArray, FloatArray, IntArray, choice, did_you_mean, kind_of, to_integers
from ..errors import InputError
from ..support.computed_once import computed_once, held
from ..support.distinct import distinct
from ..support.immutable import own
from ..support.texts import counted
from .any_geometry import NO_ATTRIBUTES, AnyGeometry, CoreData
from .foreign import lines
from .hit_places import Float64Array, HitPlaces
from .kinds import KINDS
from .offsets import NO_OFFSET, Offset, warn_of_places
from .seen_rows import SeenRows
from .summary import summary_of
from .user_primitives import UserPrimitives, has_user_methods


@dataclass(frozen=True, eq=False, repr=False)
class Geometry(AnyGeometry):
    """Several containers of primitives for one tree; hits say which `part`, and which `prim` of it.

    Boxes of its trees bound whole primitives, with their own radii. So a tree over spheres of very different sizes is
    better as a `Geometry` of them than without.

    Parameters
    ----------
    parts : sequence of Lines, Spheres, Curves, Triangles and Boxes

    Examples
    --------
    >>> import fastlines as fl
    >>> floor = fl.Triangles([[[-9, -9, 0], [9, -9, 0], [0, 9, 0]]])
    >>> ball = fl.Spheres.from_centres([[0, 0, 5]], radius=1)
    >>> tree = fl.build(fl.Geometry([floor, ball]))
    >>> hits = tree.first_hit([[0, 0, 9], [3, -5, 9], [99, 0, 9]], [0, 0, -1], at="surface")
    >>> print(hits.part, hits.prim, hits.t)
    [ 1  0 -1] [ 0  0 -1] [ 3.  9. inf]
    """

    kind: ClassVar[str] = "shapes"
    has_parts = True

    parts: tuple[AnyGeometry, ...]

    def __init__(self, parts: Sequence[AnyGeometry]) -> None:
        if not isinstance(parts, Sequence | Iterator) or isinstance(parts, str):
            raise InputError(f"parts are {kind_of(parts)}; expected a list of {_names()}")
        parts = tuple(parts)
        for i, part in enumerate(parts):
            if has_user_methods(part) or isinstance(part, UserPrimitives):
                raise InputError(f"part {i} is a class of your own; build a tree over it alone, and query both trees")
            if not isinstance(part, AnyGeometry) or not part.can_be_part:
                raise InputError(f"part {i} is {kind_of(part)}; expected one of {_names()}")
        object.__setattr__(self, "parts", parts)
        if len(offsets := {part.offset for part in parts if part.has_axes}) > 1:
            several = " and ".join(map(str, sorted(offsets)))
            raise InputError(f"parts have different offsets, {several}; read or make all of them with the same offset=")
        warn_of_places(parts)

    def __setstate__(self, state: dict[str, Any]) -> None:
        object.__setattr__(self, "parts", state["parts"])

    def __len__(self) -> int:
        return sum(map(len, self.parts))

    def __repr__(self) -> str:
        return f"<Geometry: {', '.join(map(repr, self.parts))}>"

    @computed_once
    def first(self) -> IntArray:
        """The number of primitives in the parts before each one, and in all, (n_parts + 1,) int64."""
        return np.asarray(own(np.cumsum([0, *map(len, self.parts)], dtype=np.int64)))

    @property
    def bounds(self) -> FloatArray:
        """The box of all parts as (2, 3), without their radii: lowest and highest corner."""
        boxes = [part.bounds for part in self.parts] or [np.array([[np.inf] * 3, [-np.inf] * 3], np.float32)]
        corners = np.stack(boxes)
        return np.stack([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])

    # --- What the core gets ---

    @computed_once
    def core_rows(self) -> FloatArray:
        """One row of numbers for each primitive, as the core reads them: (n, 10) float32."""
        rows = [part.shape_rows for part in self.parts]
        return np.asarray(own(np.concatenate([np.empty((0, 10), np.float32), *rows])))

    @computed_once
    def owner(self) -> IntArray:
        """The primitive of each row of `core_rows`, counted over all parts, (n_rows,) int64."""
        rows = [first + part.owner for first, part in zip(self.first, self.parts, strict=False)]
        return np.asarray(own(np.concatenate([np.zeros(0, np.int64), *rows])))

    def seen_data(self, parts: tuple[int, ...] | None) -> CoreData:
        """See `AnyGeometry`."""
        if parts is None:
            return self.core_data()
        with held(self, "seen"):
            return self.kind, self._seen.of(parts)

    @computed_once
    def _seen(self) -> SeenRows:
        return SeenRows(self.core_rows, [len(part.owner) for part in self.parts])

    @property
    def in_pieces(self) -> bool:
        """See `AnyGeometry`."""
        return any(part.in_pieces for part in self.parts)

    def parameter(self, piece: IntArray, s: FloatArray) -> tuple[IntArray, FloatArray]:
        """See `AnyGeometry`."""
        u, begin = s.copy(), 0
        for part in self.parts:
            end = begin + len(part.owner)
            here = (begin <= piece) & (piece < end)
            u[here] = part.parameter(piece[here] - begin, s[here])[1]
            begin = end
        return self.owner[piece], u

    def require_gpu_rays(self) -> None:
        """See `AnyGeometry`."""
        raise InputError("the CPU says which part of a Geometry is hit; pass rays as NumPy arrays")

    # --- Parts ---

    def each_part(self) -> tuple[AnyGeometry, ...]:
        """Return the parts."""
        return self.parts

    def check_parts(self, parts: npt.ArrayLike) -> tuple[int, ...] | None:
        """See `AnyGeometry`."""
        given = to_integers(parts, "parts")
        if given.ndim > 1:
            raise InputError(f"parts have shape {given.shape}; expected the number of a part, or several")
        numbers = distinct(given)
        if len(numbers) and not 0 <= numbers[0] <= numbers[-1] < len(self.parts):
            wrong = numbers[0] if numbers[0] < 0 else numbers[-1]
            raise InputError(f"parts names {wrong}; there are {counted(len(self.parts), 'parts')}, which count from 0")
        return None if len(numbers) == len(self.parts) else tuple(numbers.tolist())

    def split(self, prim: IntArray) -> tuple[IntArray, IntArray]:
        """See `AnyGeometry`."""
        part = np.searchsorted(self.first, prim, side="right") - 1
        return part, np.where(prim < 0, -1, prim - self.first[part])

    def number(self, part: IntArray | None, prim: IntArray) -> IntArray:
        """See `AnyGeometry`."""
        return prim if part is None else np.where(prim < 0, -1, self.first[part] + prim)

    def _by_part(self, prim: IntArray) -> Iterator[tuple[AnyGeometry, IntArray, IntArray]]:
        """Yield each part that some primitives are of, with the rows of these, and their numbers there."""
        part, prim = self.split(prim)
        for i in distinct(part):
            rows = np.flatnonzero(part == i)
            yield self.parts[i], rows, prim[rows]

    def _at(self, hits: HitPlaces, ask: Callable[[AnyGeometry, HitPlaces], Float64Array]) -> Float64Array:
        """Return vectors at hits, (n, 3), which each part tells of its own."""
        found = np.full((len(hits.prim), 3), np.nan)
        self._filled(found, hits.prim, lambda part, rows, prim: ask(part, replace(hits.some(rows), prim=prim)))
        return found

    def _filled(self, found: AnyArray, prim: IntArray, ask: Callable[[AnyGeometry, IntArray, IntArray], Any]) -> Any:
        """Fill rows with what each part tells of some primitives: their rows, and their numbers there."""
        for part, rows, numbers in self._by_part(prim):
            found[rows] = ask(part, rows, numbers)
        return found

    # --- Extent ---

    def span(self) -> tuple[FloatArray, FloatArray]:
        """See `AnyGeometry`."""
        spans = [part.span() for part in self.parts]
        points = np.concatenate([np.empty((0, 3), np.float32), *(points for points, _ in spans)])
        return points, np.concatenate([np.empty(0, np.float32), *(radii for _, radii in spans)])

    @property
    def takes_radius(self) -> bool:
        """See `AnyGeometry`."""
        return any(part.takes_radius for part in self.parts)

    @property
    def max_radius(self) -> float:
        """See `AnyGeometry`."""
        return max((part.max_radius for part in self.parts), default=0.0)

    @property
    def radius_beyond(self) -> float:
        """Always 0: the boxes of trees include radii."""
        return 0.0

    @property
    def radius_range(self) -> tuple[float, float] | None:
        """See `AnyGeometry`."""
        known = [found for part in self.parts if (found := part.radius_range) is not None]
        return (min(low for low, _ in known), max(high for _, high in known)) if known else None

    @property
    def needs_radius(self) -> bool:
        """See `AnyGeometry`."""
        return any(part.needs_radius for part in self.parts)

    def radius_of(self, prim: IntArray) -> Float64Array:
        """See `AnyGeometry`."""
        return np.asarray(self._filled(np.zeros(len(prim)), prim, lambda part, _, numbers: part.radius_of(numbers)))

    # --- Hits ---

    @property
    def has_axes(self) -> bool:
        """See `AnyGeometry`."""
        return any(part.has_axes for part in self.parts)

    def points_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda part, of_part: part.points_at(of_part))

    def nearest_at(self, hits: HitPlaces, surface: bool) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda part, of_part: part.nearest_at(of_part, surface))

    def normals_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda part, of_part: part.normals_at(of_part))

    def tangents_at(self, hits: HitPlaces) -> Float64Array:
        """See `AnyGeometry`."""
        return self._at(hits, lambda part, of_part: part.tangents_at(of_part))

    def lines_at(self, prim: IntArray, u: FloatArray) -> FloatArray:
        """See `AnyGeometry`."""
        found = super().lines_at(prim, u)
        return np.asarray(self._filled(found, prim, lambda part, at, numbers: part.lines_at(numbers, u[at])))

    def smooth_tangents_at(self, prim: IntArray, u: FloatArray, tangents: FloatArray) -> FloatArray:
        """See `AnyGeometry`."""
        found = tangents.copy()
        self._filled(found, prim, lambda part, at, numbers: part.smooth_tangents_at(numbers, u[at], tangents[at]))
        return found

    def rows_of(self, prim: IntArray) -> IntArray:
        """See `AnyGeometry`."""
        return np.asarray(self._filled(np.zeros_like(prim), prim, lambda part, _, numbers: part.rows_of(numbers)))

    def strands_of(self, prim: IntArray) -> IntArray:
        """See `AnyGeometry`; each part counts its own strands."""
        return np.asarray(self._filled(np.zeros_like(prim), prim, lambda part, _, numbers: part.strands_of(numbers)))

    # --- Attributes ---

    @property
    def sample_names(self) -> Mapping[str, None]:
        """See `AnyGeometry`."""
        return dict.fromkeys(name for part in self.parts for name in part.sample_names)

    def sample(self, name: str, hits: HitPlaces) -> npt.NDArray[Any]:
        """See `AnyGeometry`; NaN at hits of parts without the attribute."""
        if name not in self.sample_names:
            raise InputError(f"name={name!r} is not an attribute of any part{did_you_mean(name, self.sample_names)}")
        found = np.full((len(hits.prim), *self.sample_shape(name)), np.nan)
        for part, rows, prim in self._by_part(hits.prim):
            if name in part.sample_names:
                found[rows] = part.sample(name, replace(hits.some(rows), prim=prim))
        return found

    def sample_needs_rays(self, name: str) -> bool:
        """See `AnyGeometry`."""
        return any(part.sample_needs_rays(name) for part in self.parts)

    def sample_shape(self, name: str) -> tuple[int, ...]:
        """See `AnyGeometry`; refuse parts whose values differ in it."""
        shapes = {part.sample_shape(name) for part in self.parts if name in part.sample_names}
        if len(shapes) > 1:
            raise InputError(f"{name!r} has different shapes in the parts, {', '.join(map(str, sorted(shapes)))}")
        return shapes.pop()

    def arrays_of(self, name: str) -> list[tuple[AnyArray, int]]:
        """See `AnyGeometry`."""
        return [found for part in self.parts for found in part.arrays_of(name)]

    def attribute_types(self) -> dict[str, str]:
        """See `AnyGeometry`; of the first part that has the attribute."""
        found: dict[str, str] = {}
        for part in self.parts:
            found = found | {name: kind for name, kind in part.attribute_types().items() if name not in found}
        return found

    def attribute_texts(self) -> dict[str, list[str]]:
        """See `AnyGeometry`; several where parts differ."""
        found: dict[str, dict[str, None]] = {}
        for part in self.parts:
            for name, texts in part.attribute_texts().items():
                found.setdefault(name, {}).update(dict.fromkeys(texts))
        return {name: list(texts) for name, texts in found.items()}

    # --- Strands, and how lines run ---

    @property
    def n_strands(self) -> int:
        """See `AnyGeometry`; each part counts its own strands."""
        return sum(part.n_strands for part in self.parts)

    def strand_sizes(self) -> IntArray:
        """See `AnyGeometry`."""
        return np.concatenate([np.zeros(0, np.int64), *(part.strand_sizes() for part in self.parts)])

    @property
    def total_length(self) -> float:
        """See `AnyGeometry`."""
        return float(sum(part.total_length for part in self.parts))

    def strand_lengths(self) -> Float64Array:
        """See `AnyGeometry`."""
        return np.concatenate([np.empty(0), *(part.strand_lengths() for part in self.parts)])

    def count_points(self) -> int:
        """See `AnyGeometry`."""
        return sum(part.count_points() for part in self.parts)

    def count_repeats(self) -> int:
        """See `AnyGeometry`; primitives of different parts are different."""
        return sum(part.count_repeats() for part in self.parts)

    # --- Words ---

    def count_text(self) -> str:
        """See `AnyGeometry`."""
        counts = Counter[str]()
        for part in self.parts:
            counts[part.noun] += len(part)
        return ", ".join(counted(n, noun) for noun, n in counts.items()) or "nothing"

    @property
    def n_skipped(self) -> int:
        """See `AnyGeometry`."""
        return sum(part.n_skipped for part in self.parts)

    @property
    def up(self) -> str | None:
        """The axis that points upwards, of the first part that knows."""
        return next((part.up for part in self.parts if part.up), None)

    @property
    def unit(self) -> str | None:
        """The unit of length, of the first part that knows."""
        return next((part.unit for part in self.parts if part.unit), None)

    @property
    def metadata(self) -> Mapping[str, Any]:  # type: ignore[override]
        """The metadata of the first part that has any."""
        return next((part.metadata for part in self.parts if part.metadata), NO_ATTRIBUTES)

    @property
    def offset(self) -> Offset:
        """The offset of lines and curves, which all have the same; triangles and boxes are to be less it, too."""
        return next((part.offset for part in self.parts if part.has_axes), NO_OFFSET)

    def without_offset(self) -> AnyGeometry:
        """See `AnyGeometry`."""
        return self if self.offset == NO_OFFSET else Geometry([part.without_offset() for part in self.parts])

    def summary(self) -> dict[str, Any]:
        """See `AnyGeometry`."""
        counts = Counter[str]()
        for part in self.parts:
            counts[f"n_{type(part).__name__.lower()}"] += len(part)
        return summary_of(self, counts)

    def without_radius(self) -> NoReturn:
        """See `AnyGeometry`."""
        thick = [(i, part) for i, part in enumerate(self.parts) if part.is_plain and part.radius is not None]
        which = ", ".join(f"part {i} ({part.count_text()})" for i, part in thick)
        how = f", or drop the radius of {which} first: dataclasses.replace(part, radius=None)" if thick else ""
        raise InputError(f"own_radius=False is for lines, this is a Geometry; leave it out{how}")


def as_geometry(geometry: Any, *, invalid: str = "error") -> AnyGeometry:
    """Return geometry as it is; take what `lines` takes, and an object with `bounds` and `hit` for your own."""
    choice("invalid", invalid, INVALID)
    if isinstance(geometry, AnyGeometry):
        return geometry
    return UserPrimitives(geometry) if has_user_methods(geometry) else lines(geometry, invalid=invalid)


def _names() -> str:
    return ", ".join(name for name, kind in KINDS.items() if kind.can_be_part)
