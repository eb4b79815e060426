"""Curves: cubic curves with their thickness, strands and attributes, as plain arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..arrays import (
    LEAST,
    AnyArray,
    FloatArray,
    IntArray,
    box_of,
    choice,
    kind_of,
    number,
    refuse_masked,
    refuse_rows,
    unusable,
)
from ..engines import engine
from ..errors import InputError
from ..support.computed_once import computed_once
from ..support.immutable import frozen
from .any_geometry import AnyGeometry, Section
from .axis_geometry import AxisArrays, AxisGeometry
from .bezier import CurvePoints, Float64Array, evaluate, largest
from .curve_input import check_attributes, check_columns, convert_bezier, convert_strands, valid
from .curve_pieces import Pieces, as_places, cut_curves
from .lines import AXES, Lines, check_unit
from .offsets import checked_metadata


@dataclass(frozen=True, eq=False, repr=False)
class Curves(AxisGeometry):
    """Immutable cubic curves, with a thickness, strands and other attributes; writeable arrays are copied.

    The constructor takes arrays of exactly these types; `from_bezier` and `from_strands` convert others.

    Attributes
    ----------
    control : (n, 4, 3) float32
        The Bezier control points of each curve.
    radius : None or (n, 4) float32
        The Bezier coefficients of the radius, half the thickness. The outer two are the radius at both ends. The inner
        two may be negative; where the radius would be, it is 0.
    strands : (n,) int64
        The strand (hair, fibre, spline) that each curve is part of; -1, the default, where there is none.
    attributes : mapping of str to array
        Any other arrays, one row per curve.
    end_attributes : mapping of str to array
        What is known at both ends, (n, 2, …). `attributes` has the value of the first end, by the same name.
    skipped : (k,) int64
        Rows of the input that were left out because of ``invalid="skip"``.
    up : {"x", "y", "z"}, optional
        The axis that points upwards.
    unit : str, optional
        The unit of the coordinates, such as ``"mm"``.
    tolerance : float, optional
        How far the pieces may be from the curves at most, as a length; see `pieces`. By default it is 1 % of the local
        radius, and at most 1e-4 of the curve's box. The local radius is at least a tenth of the curve's largest.
    metadata : mapping of str to value
        As of `Lines`.

    Examples
    --------
    >>> import fastlines as fl
    >>> quarter = fl.Curves.from_bezier([[[1, 0, 0], [1, 0.5523, 0], [0.5523, 1, 0], [0, 1, 0]]], radius=0.1)
    >>> quarter
    <Curves: 1 curve, radius>
    >>> len(quarter.pieces)
    54
    >>> print(quarter.evaluate(0, 0.5).points.round(3))
    [0.707 0.707 0.   ]
    """

    control: FloatArray
    radius: FloatArray | None = None
    strands: IntArray = None  # type: ignore[assignment]  # becomes an array of -1
    attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    end_attributes: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    skipped: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    up: str | None = None
    tolerance: float | None = None
    unit: str | None = None
    metadata: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        good = isinstance(self.control, np.ndarray) and self.control.flags.c_contiguous
        if not good or self.control.dtype != np.float32 or self.control.shape[1:] != (4, 3):
            raise InputError(
                f"Curves take a contiguous float32 array of shape (n, 4, 3), not {kind_of(self.control)}; "
                "Curves.from_bezier converts other arrays and lists"
            )
        if self.strands is None:
            object.__setattr__(self, "strands", np.full(len(self), -1, np.int64))
        check_columns(self.control, self.radius, self.strands, self.skipped)
        check_attributes(self.attributes, self.end_attributes, len(self))
        if self.up is not None:
            choice("up", self.up, AXES)
        check_unit(self.unit)
        object.__setattr__(self, "metadata", checked_metadata(self.metadata))
        if self.tolerance is not None:
            tolerance = number("tolerance", self.tolerance, "a length above 0, or None for the default", LEAST)
            object.__setattr__(self, "tolerance", tolerance)
        for name in ("control", "radius", "strands", "skipped", "end_attributes", "attributes"):
            value = getattr(self, name)
            if name == "attributes":
                value = {**value, **{end: values[:, 0] for end, values in self.end_attributes.items()}}
            refuse_masked(value, name)
            object.__setattr__(self, name, frozen(value))
        refuse_rows(unusable(self.control), "curves", "; Curves.from_bezier(…, invalid='skip') leaves them out")

    def __len__(self) -> int:
        return len(self.control)

    @property
    def bounds(self) -> FloatArray:
        """The box of all control points as (2, 3), without any radius; lowest > highest corner if there are none."""
        return box_of(self.control.reshape(-1, 3))

    @property
    def tree_bounds(self) -> FloatArray:
        """The box of the pieces."""
        return self.straight.bounds

    @computed_once
    def max_radius(self) -> float:
        """The largest radius anywhere on a curve; 0 if there is none."""
        if self.radius is None:
            return 0.0
        return float(largest(self.radius.astype(np.float64)).max(initial=0))

    @computed_once
    def pieces(self) -> Pieces:
        """The round cones that stand for the curves: chords that are off by at most the tolerance.

        Each curve is halved until the swept balls of each piece differ from those of its part of the curve by at most
        the tolerance (Hausdorff distance), and so does the point of the piece from that of the curve with the same
        parameter. `curve_pieces.py` derives the bound and the default tolerance.

        The ends of pieces are rounded to float32. A curve has at most 4096 pieces; a `PrecisionWarning` reports those
        that would need more.

        A curve whose control points are all equal is one piece of length zero, with its largest radius.
        """
        facts = {"up": self.up, "unit": self.unit, "metadata": self.metadata}
        return cut_curves(self.control, self.radius, self.strands, self.tolerance, facts)

    def locate(self, curve: npt.ArrayLike, u: npt.ArrayLike) -> tuple[IntArray, Float64Array]:
        """Return the piece that a place on a curve is on, and the place on that piece, from 0 to 1.

        Parameters
        ----------
        curve : int or (…) array of int
            The position of each curve in these.
        u : number or (…) array
            The parameter, from 0 to 1. Where two pieces meet, it is the start of the latter.

        Examples
        --------
        >>> curves = Curves.from_bezier([[[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 0, 0]]], tolerance=0.2)
        >>> piece, s = curves.locate(0, [0, 0.3, 0.5, 1])
        >>> print(piece, s)
        [0 0 1 1] [0.  0.6 0.  1. ]
        >>> print(*curves.parameter(piece, s))
        [0 0 0 0] [0.  0.3 0.5 1. ]
        """
        return self.pieces.locate(curve, u)

    def parameter(self, piece: npt.ArrayLike, s: npt.ArrayLike) -> tuple[IntArray, FloatArray]:
        """Return the curve of a piece, and the parameter of a place on that piece, as float32: `locate` backwards.

        Parameters
        ----------
        piece : int or (…) array of int
            The position of each piece in `pieces`, as `prim` has it for a tree of ``pieces.lines``.
        s : number or (…) array
            The place on the piece, from 0 to 1.
        """
        return self.pieces.parameter(piece, s)

    def evaluate(self, curve: npt.ArrayLike, u: npt.ArrayLike) -> CurvePoints:
        """Return points of curves, with the unit tangents and the radii there, in float64.

        Parameters
        ----------
        curve : int or (…) array of int
            The position of each curve in these.
        u : number or (…) array
            The parameter, from 0 to 1.

        Returns
        -------
        CurvePoints
            ``points`` and ``tangents``, (…, 3), and ``radius``, (…); 0 if there is none. Where a curve stands still, as
            at a cusp, the tangent is where it goes on; for a curve that is one point, it is NaN.

        Examples
        --------
        >>> curves = Curves.from_bezier([[[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 0, 0]]], radius=[[0.5, 0.1]])
        >>> at = curves.evaluate(0, [0, 0.5])
        >>> print(at.points[1], at.tangents[1], at.radius)
        [1.5  0.75 0.  ] [1. 0. 0.] [0.5 0.3]
        """
        rows, at = np.broadcast_arrays(*as_places("curve", curve, len(self), "u", u))
        flat, along = rows.reshape(-1), at.reshape(-1)
        points, tangents = evaluate(self.control[flat].astype(np.float64), along)
        radius = np.zeros(len(flat))
        if self.radius is not None:
            radius = np.maximum(evaluate(self.radius[flat, :, None].astype(np.float64), along)[0][:, 0], 0)
        return CurvePoints(
            points.reshape(*at.shape, 3) + self.offset, tangents.reshape(*at.shape, 3), radius.reshape(at.shape)
        )

    # --- What a kind of geometry answers ---

    place_words = "end of a curve", "curve"
    noun = "curves"
    in_pieces = True
    #: A curve is drawn as this many chords.
    strokes = 8
    sections: ClassVar[Mapping[str, Section]] = {
        "control": ("<f4", ((4, 3),), True),
        "strands": ("<i8", ((),), True),
        "radius": ("<f4", ((4,),), False),
        "skipped": ("<i8", ((),), False),
    }

    @property
    def straight(self) -> Lines:
        """The pieces."""
        return self.pieces.lines

    @property
    def control_points(self) -> FloatArray:
        """The Bezier control points."""
        return self.control

    @property
    def compiled_axes(self) -> AxisArrays:
        """See `AxisGeometry`."""
        pieces = self.pieces
        return super().compiled_axes[0], (self.control, self.radius, pieces.first, pieces.begin, pieces.end)

    @property
    def owner(self) -> IntArray:
        """The curve of each piece."""
        return self.pieces.curve

    def on_prims(self, piece: IntArray, s: FloatArray) -> tuple[IntArray, FloatArray]:
        """See `AnyGeometry`; compiled."""
        return engine.on_curves(piece, s, self.pieces.curve, self.pieces.begin, self.pieces.end)

    def require_gpu_rays(self) -> None:
        """See `AnyGeometry`."""
        raise InputError("hits of curves are put together on the CPU; pass rays as NumPy arrays")

    def axis_points(self, prim: IntArray, u: AnyArray) -> Float64Array:
        """See `AnyGeometry`."""
        return np.asarray(self.evaluate(prim, u).points - self.offset, np.float64)

    def begins(self) -> npt.NDArray[np.bool_]:
        """See `AnyGeometry`; curves go on only with the same radius."""
        begins = super().begins()
        if self.radius is not None:
            begins[1:] |= self.radius[1:, 0] != self.radius[:-1, 3]
        return begins

    def drawn(self, rows: IntArray) -> Sequence[AnyGeometry]:
        """Return a few chords of each curve."""
        at = self.evaluate(rows[:, None], np.linspace(0, 1, self.strokes + 1))
        both = at.points - self.offset, at.radius
        points, radii = (np.stack([v[:, :-1], v[:, 1:]], axis=2).astype(np.float32) for v in both)
        radius = None if self.radius is None else radii.reshape(-1, 2)
        return (Lines(points.reshape(-1, 2, 3), radius=radius, up=self.up),)

    @property
    def is_plain(self) -> bool:
        """See `AnyGeometry`."""
        return type(self) is Curves

    def as_lines(self) -> Lines:
        """Return the pieces as lines with the attributes of the curves.

        Values at both ends are interpolated linearly in the parameter; integers and booleans are those of the nearer.
        """
        return self.pieces.with_attributes(self.attributes, self.end_attributes)

    @classmethod
    def from_bezier(
        cls,
        control: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        *,
        strands: npt.ArrayLike | None = None,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        end_attributes: Mapping[str, npt.ArrayLike] | None = None,
        up: str | None = None,
        tolerance: float | None = None,
        offset: Any = None,
        invalid: str = "error",
    ) -> Curves:
        """Make curves of Bezier control points.

        Parameters
        ----------
        control : (n, 4, 3) array
            Converted to float32.
        radius : number, (n,), (n, 2) or (n, 4) array, optional
            One for all; one for each curve; one for each end, linear between them; or the Bezier coefficients.
        strands, attributes, end_attributes, up, tolerance, offset
            As in `Curves`; the offset as in `Lines.from_segments`.
        invalid : {"error", "skip"}
            Refuse curves with NaN, Inf, a coordinate beyond 1e30 or a radius outside of 0 to 1e30, or leave them out.

        Raises
        ------
        InputError
            If the shape, the type or a value cannot be used.
        """
        made = convert_bezier(control, radius, strands, attributes, end_attributes, invalid)
        return cls(**valid(made, invalid, offset), up=up, tolerance=tolerance)

    @classmethod
    def from_strands(
        cls,
        points: npt.ArrayLike,
        counts: npt.ArrayLike,
        *,
        basis: str = "bezier",
        wrap: str = "nonperiodic",
        radius: npt.ArrayLike | None = None,
        tangents: npt.ArrayLike | None = None,
        attributes: Mapping[str, npt.ArrayLike] | None = None,
        up: str | None = None,
        tolerance: float | None = None,
        offset: Any = None,
        invalid: str = "error",
    ) -> Curves:
        """Make curves of splines, with the meaning that USD's BasisCurves give to bases, wraps and points.

        Parameters
        ----------
        points : (m, 3) array
            The points of all strands, one strand after the other.
        counts : (k,) array of int
            How many points each strand has; they add up to m. A strand without points has no curves.
        basis : {"bezier", "bspline", "catmull-rom", "hermite"}
            Converted to Bezier curves in float64, and then rounded to float32. A Bezier strand shares points: it has 4,
            7, 10, … of them. B-splines and Catmull-Rom splines have uniform knots and need 4 points or more, Hermite
            curves 2.
        wrap : {"nonperiodic", "periodic", "pinned"}
            Periodic strands are closed; Bezier ones have 3, 6, 9, … points, others 1 or more. Pinned B-splines and
            Catmull-Rom splines begin at their first point, end at their last, and have 2 or more. Other curves do so
            anyway.
        radius : number or (m,) array, optional
            Half the thickness, everywhere or at each point, in the same basis; linear along each Hermite curve. Where a
            Catmull-Rom spline overshoots below 0, the radius is 0.
        tangents : (m, 3) array, optional
            The derivative at each point, for Hermite curves only; the parameter of each curve is from 0 to 1.
        attributes : mapping of str to array of m rows, optional
            Per point; each curve has the values at both ends (`end_attributes`). At an end of a B-spline's curve,
            floating-point values are the mean of three points with the weights 1/6, 4/6, 1/6, as the curve itself is;
            others are those of the middle one.
        up, tolerance, offset, invalid
            As in `from_bezier`; each curve that depends on an invalid point is left out.

        Raises
        ------
        InputError
            If the number of points does not fit the basis and the wrap, or an array or a value cannot be used.

        Examples
        --------
        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> loop = Curves.from_strands(square, [4], basis="catmull-rom", wrap="periodic", radius=0.1)
        >>> loop
        <Curves: 4 curves, 1 strand, radius>
        >>> print(loop.evaluate([0, 3], [0, 1]).points[1])
        [1. 0. 0.]
        """
        made = convert_strands(points, counts, basis, wrap, radius, tangents, attributes, invalid)
        return cls(**valid(made, invalid, offset), up=up, tolerance=tolerance)
