"""Sums over all hits of each ray: what is summed, and the sums."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray, choice, list_rows, number, to_float32
from ..engines import engine
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.hit_places import Float64Array
from ..progress import ProgressCallback
from ..support.texts import counted
from ..threads import get_num_threads
from .backend import Backend, GatherColumns
from .rays import RayBatch, seen_of
from .run_lists import list_runs

#: The kernels that spread a hit over the reach of its ray.
BLURS = ("box", "epanechnikov", "none")

#: The most numbers that a primitive has for a sum.
MAX_CHANNELS = 8

#: The most that lists of hits take, where hits are listed before they are summed; and what a hit takes there.
LIST_BYTES, BYTES_A_HIT = 1 << 28, 200

#: The blur, the number of channels, both extinctions of each, the phase, whether ends are left out, values, depths.
RuleArrays: TypeAlias = tuple[
    str, int, list[float], list[float], float | None, bool, FloatArray | None, FloatArray | None
]


@dataclass(frozen=True, eq=False, repr=False)
class Gathered:
    """Sums over all hits of each ray, in the shape of the rays; with channels, these are the last dimension.

    Attributes
    ----------
    sum : float64
        The sum of all contributions.
    squares : float64 or None
        The sum of their squares, for an estimate of the variance; None unless asked for.
    count : int64 of the shape of the rays
        How many hits have contributed.
    skipped : (k,) int64
        With ``invalid="skip"``, the invalid rays, whose sums are 0.
    """

    sum: Float64Array
    squares: Float64Array | None
    count: IntArray
    skipped: IntArray

    def __repr__(self) -> str:
        return f"<Gathered: {counted(self.count.size, 'rays')}, {counted(int(self.count.sum()), 'hits')}>"


@dataclass(frozen=True, eq=False)
class GatherArguments:
    """What to sum, before it is checked; `Tree.gather` explains it."""

    values: npt.ArrayLike | None = None
    blur: str = "box"
    sigma: npt.ArrayLike = 0.0
    line_sigma: npt.ArrayLike = 0.0
    optical_depth: npt.ArrayLike | None = None
    phase: float | None = None
    inner: bool = True
    squares: bool = False


@dataclass(frozen=True, eq=False)
class GatherRule:
    """What is summed for each ray of a batch, checked."""

    blur: str
    n_channels: int
    #: Whether sums have a dimension for channels.
    has_channels: bool
    #: (n_channels,) each.
    sigma: FloatArray
    line_sigma: FloatArray
    phase: float | None
    inner: bool
    squares: bool
    #: (n_prims, n_channels) or None for ones.
    values: FloatArray | None
    #: (n_rays, n_steps, n_channels or 1) or None.
    depths: FloatArray | None

    @classmethod
    def of(cls, given: GatherArguments, geometry: AnyGeometry, rays: RayBatch) -> GatherRule:
        """Check what to sum for these rays."""
        blur = choice("blur", given.blur, BLURS)
        values = None if given.values is None else _values(given.values, len(geometry))
        sigma, line_sigma = _extinction("sigma", given.sigma), _extinction("line_sigma", given.line_sigma)
        depths = None if given.optical_depth is None else _depths(given.optical_depth, rays)
        if depths is not None and sigma.any():
            raise InputError("optical_depth= stands for sigma= along the rays; pass one of them")
        channels = _channels({"values": values, "sigma": sigma, "line_sigma": line_sigma, "optical_depth": depths})
        n_channels = channels or 1
        _check_lines(given, blur, geometry)
        if blur != "none":
            _require_width(geometry, rays)
        if values is not None:
            columns = values if values.ndim == 2 else values[:, None]
            values = np.ascontiguousarray(np.broadcast_to(columns, (len(values), n_channels)))
        return cls(
            blur,
            n_channels,
            channels is not None,
            np.broadcast_to(sigma, n_channels),
            np.broadcast_to(line_sigma, n_channels),
            None if given.phase is None else _phase(given.phase),
            bool(given.inner),
            bool(given.squares),
            values,
            depths if depths is None or depths.ndim == 3 else depths[:, :, None],
        )

    def part(self, begin: int, end: int) -> GatherRule:
        """Return the rule for consecutive rays."""
        return self if self.depths is None else replace(self, depths=self.depths[begin:end])

    def arrays(self) -> RuleArrays:
        """Return what the engine reads."""
        sigma, line_sigma = (
            np.concatenate([each, np.zeros(MAX_CHANNELS - self.n_channels, np.float32)]).tolist()
            for each in (self.sigma, self.line_sigma)
        )
        return self.blur, self.n_channels, sigma, line_sigma, self.phase, self.inner, self.values, self.depths

    def gathered(self, columns: GatherColumns, rays: RayBatch) -> Gathered:
        """Return the columns of a backend in the shape of the rays."""
        sums, squares, count = columns
        shape = (*rays.shape, self.n_channels) if self.has_channels else rays.shape
        squares = None if squares is None else squares.reshape(shape)
        return Gathered(sums.reshape(shape), squares, count.reshape(rays.shape).view(np.int64), rays.skipped)


def gather_lists(
    backend: Backend, geometry: AnyGeometry, rays: RayBatch, rule: GatherRule, progress: ProgressCallback | None
) -> GatherColumns:
    """Sum over lists of all hits, some rays at a time."""
    sums = np.zeros((len(rays), rule.n_channels))
    squares = np.zeros((len(rays), rule.n_channels)) if rule.squares else None
    count = np.zeros(len(rays), np.int64)
    runs = list_runs(backend, rays, "closest", BYTES_A_HIT, LIST_BYTES, progress, least_rays=1)
    for begin, part, (offsets, columns) in runs:
        t, prim, u, distance, _ = columns
        here = slice(begin, begin + len(part))
        found = engine.gather_lists(
            part.arrays(),
            (offsets, t, prim, u, distance),
            geometry.lines_at(prim, u),
            rule.part(here.start, here.stop).arrays(),
            rule.squares,
            get_num_threads(),
            None,
        )
        sums[here], count[here] = found[0], found[2]
        if squares is not None:
            squares[here] = found[1]
    return sums, squares, count


def _channels(given: dict[str, FloatArray | None]) -> int | None:
    """Return how many channels the values, extinctions and depths have; None if all have one number for all."""
    scalar = {"values": 1, "sigma": 0, "line_sigma": 0, "optical_depth": 2}  # the dimensions without channels
    widths = {name: a.shape[-1] for name, a in given.items() if a is not None and a.ndim > scalar[name]}
    if len(set(widths.values())) > 1:
        several = ", ".join(f"{name} has {width}" for name, width in widths.items())
        raise InputError(f"{several} channels; expected the same number in each, or one number for all channels")
    n_channels = max(widths.values(), default=None)
    if n_channels is not None and n_channels > MAX_CHANNELS:
        raise InputError(f"{n_channels} channels are more than one call sums, {MAX_CHANNELS}; use several calls")
    return n_channels


def _values(given: npt.ArrayLike, n_prims: int) -> FloatArray:
    values = to_float32(given, "values")
    if values.ndim not in (1, 2) or len(values) != n_prims or 0 in values.shape[1:]:
        raise InputError(
            f"values have shape {values.shape}; expected ({n_prims},), a number for each primitive, or ({n_prims}, C) "
            f"with up to {MAX_CHANNELS} channels"
        )
    bad = ~np.isfinite(values)
    if bad.any():
        raise InputError(f"values hold NaN, Inf or what float32 cannot hold ({list_rows(_any_of_row(bad))}); fill them")
    return values


def _any_of_row(bad: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    return np.asarray(bad.reshape(len(bad), -1).any(axis=1))


def _extinction(name: str, given: npt.ArrayLike) -> FloatArray:
    sigma = to_float32(given, name)
    if sigma.ndim > 1 or 0 in sigma.shape:
        raise InputError(f"{name} has shape {sigma.shape}; expected a number, or (C,) with one for each channel")
    if not (np.isfinite(sigma) & (sigma >= 0)).all():
        raise InputError(f"{name}={given!r}; expected numbers from 0 up: an extinction per unit of length")
    return sigma


def _phase(given: Any) -> float:
    expected = "a number between -1 and 1: g of the Henyey-Greenstein function, the mean cosine; or None"
    g = number("phase", given, expected, -1, 1)
    if not -1 < float(np.float32(g)) < 1:
        raise InputError(f"phase={given!r}; expected {expected}")
    return g


def _depths(given: npt.ArrayLike, rays: RayBatch) -> FloatArray:
    """Return depths as (n_rays, n_steps) or (n_rays, n_steps, n_channels)."""
    depths, shape = to_float32(given, "optical_depth"), rays.shape
    more = depths.shape[len(shape) :]
    if depths.shape[: len(shape)] != shape or len(more) not in (1, 2) or more[0] < 2 or more[-1] == 0:
        wanted = ", ".join(map(str, (*shape, "K")))
        raise InputError(
            f"optical_depth has shape {depths.shape}; expected ({wanted}) or ({wanted}, C): the depth at K ≥ 2 equal "
            "steps from t_min to t_max of each ray"
        )
    if not np.isfinite(rays.t_max).all() or not np.isfinite(rays.t_min).all():
        raise InputError("optical_depth has equal steps from t_min to t_max; pass finite t_min= and t_max= with it")
    depths = depths.reshape(len(rays), *more)
    if len(rays.skipped):
        depths = depths.copy()
        depths[rays.skipped] = 0
    bad = ~(np.isfinite(depths) & (depths >= 0))
    if bad.any():
        raise InputError(f"optical_depth holds NaN, Inf or numbers below 0 ({list_rows(_any_of_row(bad))})")
    return np.ascontiguousarray(depths)


def _check_lines(given: GatherArguments, blur: str, geometry: AnyGeometry) -> None:
    """Refuse what needs lines, where there are none."""
    if not any(part.has_directions for part in geometry.each_part()):
        for name, value, none in (("blur", blur, "none"), ("phase", given.phase, None)):
            if value != none:
                raise InputError(
                    f"{name}={value!r} needs the directions of lines, and the tree is over {geometry.count_text()}; "
                    f"pass {name}={none!r}"
                )
    elif geometry.in_pieces and np.any(given.line_sigma):
        raise InputError(
            "line_sigma is for straight lines, along which u times the length is a length; the tree is over "
            f"{geometry.count_text()}; leave it out, or cut curves into lines"
        )


def _require_width(geometry: AnyGeometry, rays: RayBatch) -> None:
    """Refuse a blur without a width, at the lines that rays see."""
    seen = (part for each in seen_of(geometry, rays.parts) for part in each.each_part())
    if rays.has_spread or any(part.max_radius > 0 for part in seen if part.has_directions):
        return
    is_zero = np.broadcast_to(rays.radius == 0, len(rays)).copy()
    is_zero[rays.skipped] = False
    if is_zero.any():
        where = "" if len(rays.radius) == 1 else f" for some rays ({list_rows(is_zero)})"
        raise InputError(
            f"radius=0{where} leaves a blur no width; pass a radius above 0, or blur='none' for sums without a kernel"
        )
