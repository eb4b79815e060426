"""The protocol of a kind of geometry: what a container of primitives answers for itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import AnyArray, FloatArray, IntArray, did_you_mean, is_text
from ..errors import InputError
from ..support.display import Shown
from ..support.immutable import Immutable
from ..support.texts import counted
from .hit_answers import HitAnswers
from .hit_places import Float64Array, HitFrames, HitPlaces, interpolate, require_numbers
from .offsets import NO_OFFSET, OFFSET, Offset, offset_of
from .shapes import SHAPES, box_of_shapes
from .summary import summary_of

#: What the core gets: the name of the kind of primitives, and a row of numbers for each.
CoreData: TypeAlias = tuple[str, FloatArray]
#: An array of a file: its dtype, the shapes that a row may have, and whether it must be there.
Section: TypeAlias = tuple[str, tuple[tuple[int, ...], ...], bool]

NO_ATTRIBUTES: Mapping[str, Any] = MappingProxyType({})


class AnyGeometry(Shown, HitAnswers, Immutable, ABC):
    """Primitives that a tree can be over. A kind of geometry is a subclass, and a row of `kinds.KINDS`.

    Each member is one question about the kind, and the rest of the package asks these instead of testing for classes. A
    kind implements the abstract members, and those whose default is not true of it. A `Geometry` asks its parts.
    """

    # --- What the core gets ---

    @property
    @abstractmethod
    def kind(self) -> str:
        """What the core calls the primitives that queries test: the `kKind` of a set of them in C++."""

    @property
    @abstractmethod
    def core_rows(self) -> FloatArray:
        """One row of numbers for each primitive that queries test, as the core reads them, (n_rows, …) float32."""

    def core_data(self) -> CoreData:
        """Return the kind and the rows of what queries test."""
        return self.kind, self.core_rows

    def seen_data(self, parts: tuple[int, ...] | None) -> CoreData:
        """Return the kind and the rows of what rays test that see some `parts`, or all of it."""
        return self.core_data()

    def build_data(self) -> CoreData:
        """Return the kind and the rows of what trees bound."""
        return self.core_data()

    @property
    def takes_spread(self) -> bool:
        """Whether rays may have a spread."""
        return False

    def spread_data(self) -> CoreData:
        """Return the kind and the rows of what rays with a spread test: round cones, of radius 0 for plain lines."""
        raise InputError(f"a spread is for lines, and this tree is over {type(self).__name__}; leave out spread=")

    #: Whether it can be a part of a `Geometry`, which reads its `shape_rows`.
    can_be_part: ClassVar[bool] = False

    @property
    def shape_rows(self) -> FloatArray:
        """The rows of the parts of a `Geometry`, in which `shapes` are mixed: (n_rows, 10) float32."""
        return self.core_rows

    @property
    def owner(self) -> IntArray:
        """The primitive of each row of `core_rows`, (n_rows,) int64."""
        return np.arange(len(self))

    @property
    def in_pieces(self) -> bool:
        """Whether a primitive is several rows of the core, whose hits are joined."""
        return False

    def parameter(self, piece: Any, s: Any) -> tuple[IntArray, FloatArray]:
        """Return the primitives of rows of the core, and the places u on them, from those on the rows."""
        return piece, s

    def on_prims(self, piece: IntArray, s: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the same of the columns of hits, of which misses are -1."""
        prim, u, hit = np.full(len(piece), -1), s.copy(), piece >= 0
        prim[hit], u[hit] = self.parameter(piece[hit], s[hit])
        return prim, u

    @property
    def has_user_code(self) -> bool:
        """Whether a class of the user's own, in Python, decides what a ray hits."""
        return False

    def require_gpu(self) -> None:
        """Refuse what GPUs do not know."""

    def require_gpu_rays(self) -> None:
        """Refuse rays in the memory of a GPU if the CPU finishes their answers."""
        self.require_gpu()

    # --- Parts ---

    #: Whether it is several containers.
    has_parts: ClassVar[bool] = False

    def each_part(self) -> Sequence[AnyGeometry]:
        """Return the parts; what has none is its own only part."""
        return (self,)

    def check_parts(self, parts: npt.ArrayLike) -> tuple[int, ...] | None:
        """Check numbers of parts, and return them in their order; None for all."""
        raise InputError(f"parts={parts!r} names parts of a Geometry, and this is {type(self).__name__}; leave it out")

    def split(self, prim: IntArray) -> tuple[IntArray | None, IntArray]:
        """Return the part of each primitive, if there are any, and its number there; -1 for a miss."""
        return None, prim

    def number(self, part: IntArray | None, prim: IntArray) -> IntArray:
        """Return the numbers over all parts of primitives of some parts; -1 for a miss."""
        return prim

    # --- Extent ---

    @abstractmethod
    def __len__(self) -> int:
        """Return the number of primitives."""

    @property
    @abstractmethod
    def bounds(self) -> FloatArray:
        """The box without any `radius`, (2, 3): its lowest and highest corner; lowest > highest if it is empty."""

    @property
    def tree_bounds(self) -> FloatArray:
        """The box of a tree's root, in the form of `bounds`: queries have limits relative to it."""
        return box_of_shapes(self.core_rows) if self.kind == SHAPES else self.bounds

    @abstractmethod
    def span(self) -> tuple[FloatArray, FloatArray]:
        """Return points that span the primitives, (m, 3), and the radius around each, (m,)."""

    def thick_axes(self) -> tuple[FloatArray, FloatArray] | None:
        """Return straight axes (m, 2, 3) in memory, and the radii at their ends (m, 2); None if there are none."""
        return None

    @property
    def radius(self) -> FloatArray | None:
        """The radius that primitives have of their own; None if they have none."""
        return None

    @property
    def takes_radius(self) -> bool:
        """Whether the radius of a query counts for any primitive."""
        return True

    @property
    def max_radius(self) -> float:
        """The largest radius that primitives have of their own; 0 if none has one."""
        return 0.0

    @property
    def radius_beyond(self) -> float:
        """How far primitives extend beyond the boxes of a tree over them."""
        return self.max_radius

    @property
    def radius_range(self) -> tuple[float, float] | None:
        """The least and the largest radius of their own; None without any."""
        return None

    @property
    def needs_radius(self) -> bool:
        """Whether queries need a radius: some lines or curves have none of their own."""
        return False

    @property
    def is_bare(self) -> bool:
        """Whether pictures need a radius: some lines or curves have none of their own, or one that is 0 everywhere."""
        return any(part.has_axes and part.max_radius == 0 for part in self.each_part())

    def radius_of(self, prim: IntArray) -> Float64Array:
        """Return the largest radius of each of some primitives; 0 for those without."""
        return np.zeros(len(prim))

    # --- Hits ---

    def frames_at(self, hits: HitPlaces, lift: float) -> HitFrames:
        """Return what shading reads of each hit, with points that are moved along the normals."""
        normals, tangents = self.normals_at(hits), np.nan_to_num(self.tangents_at(hits))
        radius = np.nan_to_num(self.sample("radius", hits)) if self.max_radius > 0 else np.zeros(len(hits.prim))
        columns = self.points_at(hits) + lift * normals, normals, tangents, -hits.directions, radius + hits.radius
        return HitFrames(*(column.astype(np.float32) for column in columns))

    def smooth_tangents_at(self, prim: IntArray, u: FloatArray, tangents: FloatArray) -> FloatArray:
        """Return directions at hits without steps between neighbours, from the tangents of the primitives."""
        return tangents

    def rows_of(self, prim: IntArray) -> IntArray:
        """Return the row of the input that each of some primitives was."""
        return prim

    def strands_of(self, prim: IntArray) -> IntArray:
        """Return the strand of each of some primitives; -1 for none."""
        return np.full(len(prim), -1)

    @property
    def end_of_strands(self) -> int:
        """One more than the greatest number of a strand."""
        return 0

    # --- Attributes ---

    #: A row for each primitive, by name.
    attributes: Mapping[str, npt.NDArray[Any]] = NO_ATTRIBUTES

    @property
    def place_attributes(self) -> Mapping[str, npt.NDArray[Any]]:
        """Values at the ends or corners of each primitive, (n, k, …), by name."""
        return NO_ATTRIBUTES

    def place_weights(self, hits: HitPlaces) -> Float64Array:
        """Return the weights of the ends or corners at each hit, (n, k); needed with `place_attributes`."""
        raise NotImplementedError

    @property
    def sample_names(self) -> Mapping[str, None]:
        """The names that `sample` knows, in their order."""
        return dict.fromkeys([*self.place_attributes, *self.attributes])

    def sample(self, name: str, hits: HitPlaces) -> npt.NDArray[Any]:
        """Return an attribute at each hit, interpolated where there are values for ends or corners."""
        if name not in self.sample_names:
            raise InputError(f"name={name!r} is not an attribute of {self!r}{did_you_mean(name, self.sample_names)}")
        if name in self.place_attributes:
            return interpolate(require_numbers(name, self.place_attributes[name])[hits.prim], self.place_weights(hits))
        return require_numbers(name, self.attributes[name])[hits.prim]

    def sample_needs_rays(self, name: str) -> bool:
        """Whether `sample` reads the rays of hits."""
        return False

    def sample_shape(self, name: str) -> tuple[int, ...]:
        """Return the shape of one value that `sample` returns."""
        places = self.place_attributes
        return places[name].shape[2:] if name in places else self.attributes[name].shape[1:]

    def arrays_of(self, name: str) -> list[tuple[AnyArray, int]]:
        """Return the arrays of an attribute, and after how many dimensions one value of each begins."""
        return [(of[name], n) for of, n in ((self.attributes, 1), (self.place_attributes, 2)) if name in of]

    def attribute_types(self) -> dict[str, str]:
        """Return the type of each attribute, with the shape of one value, such as "float32 × 3" or "text"."""
        arrays = {**self.place_attributes, **self.attributes, **self.place_attributes}
        types = {name: "text" if is_text(values) else values.dtype for name, values in arrays.items()}
        return {name: " × ".join(map(str, (kind, *self.sample_shape(name)))) for name, kind in types.items()}

    def attribute_texts(self) -> dict[str, list[str]]:
        """Return the type of each attribute, and what it has a value for, such as "float32 per strand"."""
        return {name: [f"{kind} per {self.place_of(name)}"] for name, kind in self.attribute_types().items()}

    def place_of(self, name: str) -> str:
        """Return what an attribute has a value for, such as "strand"."""
        return "primitive"

    # --- Strands, and how lines run ---

    @property
    def n_strands(self) -> int:
        """The number of different strands."""
        return 0

    def strand_sizes(self) -> IntArray:
        """Return how many primitives each strand has."""
        return np.zeros(0, np.int64)

    def turns(self) -> FloatArray | None:
        """Return the cosine of the turn between each two segments of a strand; None for other primitives."""
        return None

    def begins(self) -> npt.NDArray[np.bool_]:
        """Return which primitives do not go on where the one before of their strand ends."""
        return np.ones(len(self), np.bool_)

    @property
    def total_length(self) -> float:
        """The length of all lines together."""
        return 0.0

    def strand_lengths(self) -> Float64Array:
        """Return the length of each strand."""
        return np.empty(0)

    def count_points(self) -> int:
        """Return how many segments and curves are one point."""
        return 0

    def count_repeats(self) -> int:
        """Return how many primitives are the same as an earlier one, in either direction."""
        return 0

    # --- Words ---

    @property
    def noun(self) -> str:
        """What the primitives are called, in the plural."""
        return type(self).__name__.lower()

    def count_text(self) -> str:
        """Return how many primitives of which kind there are, in words."""
        return counted(len(self), self.noun)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.count_text()}>"

    @property
    def n_skipped(self) -> int:
        """How many rows of the input were left out."""
        return 0

    @property
    def up(self) -> str | None:
        """The axis that points upwards, if it is known."""
        return None

    @property
    def unit(self) -> str | None:
        """The unit of length, if it is known."""
        return None

    #: What is known of the whole, as JSON holds it; read-only.
    metadata: Mapping[str, Any] = NO_ATTRIBUTES

    @property
    def offset(self) -> Offset:
        """What was subtracted from x, y and z in float64, and is added to points again; see `fastlines.read`."""
        return offset_of(self.metadata)

    def without_offset(self) -> AnyGeometry:
        """Return the same primitives, whose coordinates are those in their arrays."""
        if self.offset == NO_OFFSET:
            return self
        return replace(self, metadata={name: v for name, v in self.metadata.items() if name != OFFSET})

    #: What `fastlines info` calls it.
    heading: ClassVar[str] = "shapes"

    def summary(self) -> dict[str, Any]:
        """Return counts and sizes, ready for JSON, as `fastlines info` prints them."""
        return summary_of(self, {f"n_{type(self).__name__.lower()}": len(self)})

    # --- Pictures ---

    #: How many strokes draw a primitive, and how many consecutive ones are taken together in a sample.
    strokes: ClassVar[int] = 1
    run: ClassVar[int] = 32

    def drawn(self, rows: IntArray) -> Sequence[AnyGeometry]:
        """Return some of the primitives as lines, spheres, triangles or boxes, which have `outlines`."""
        return ()

    def outlines(self) -> tuple[Float64Array, Float64Array]:
        """Return what draws the primitives: strokes or polygons (n, k, 3), and the radius at each point, (n, k)."""
        return np.empty((0, 2, 3)), np.empty((0, 2))

    # --- Files, and other lines ---

    #: The arrays that tree files keep, by name; attributes are kept besides.
    sections: ClassVar[Mapping[str, Section]] = NO_ATTRIBUTES

    @property
    def is_plain(self) -> bool:
        """Whether the class adds nothing to lines or curves: formats of lines hold it, and its radius may go."""
        return False

    def as_lines(self) -> AnyGeometry | None:
        """Return the lines that formats without curves hold in its place; None if there are none."""
        return None

    def without_radius(self) -> AnyGeometry:
        """Return the same lines without their radius."""
        hint = self.is_plain and self.radius is not None
        how = ", or drop the radius first: dataclasses.replace(part, radius=None)" if hint else ""
        raise InputError(f"own_radius=False is for lines, these are {type(self).__name__}; leave it out{how}")

    def moved(self, lines: Any) -> AnyGeometry:
        """Return the lines for a refit; an array of segments keeps the strands, radii and attributes of these."""
        raise InputError(f"refits are for lines; this tree is over {type(self).__name__}: build it anew")
